// SPDX-License-Identifier: Apache-2.0
// Short names for clips, their frames, comparisons, and moments of logs.
import type { components } from './schema';

type Schemas = components['schemas'];

export type LastSeconds = Schemas['LastSeconds'];
export type ClipNow = Schemas['ClipNow'];
export type Clip = Schemas['Clip'];
export type Clips = Schemas['Clips'];
export type ClipFrames = Schemas['ClipFrames'];
export type ClipEvent = ClipFrames['events'][number];
export type ClipCamera = ClipFrames['cameras'][number];
export type ClipFrame = Schemas['ClipFrame'];
export type RecordedRobot = Schemas['RecordedRobot'];
export type Comparison = Schemas['Comparison'];
export type CompareWith = Comparison['with'];
export type ComparisonResult = NonNullable<Comparison['result']>;
export type Difference = ComparisonResult['differences'][number];
/** The state of a log at one moment: the newest message of each source, unless it is old. */
export type LogMoment = Schemas['MatchMoment'];
