// SPDX-License-Identifier: Apache-2.0
// Clips, their frames, comparisons, and moments of logs.
import type { Ball, Robot, Team } from './types';

export interface LastSeconds {
  memory_bytes: number;
  wanted_bytes: number;
  /** What of the images is kept: all of each, every nth, or of most of them only the parts where robots and balls may be. */
  images: 'whole' | 'every_nth' | 'found';
  every_nth: number;
  cameras: { id: number; seconds: number; frames: number; bytes: number; dropped: number }[];
  problem: string;
}

/** The clip that is written now, or the last one. */
export interface ClipNow {
  state: 'idle' | 'writing' | 'failed';
  name: string;
  why: string;
  frames: number;
  missing: number;
  bytes: number;
  error: string;
}

export interface Clip {
  name: string;
  bytes: number;
  /** Unix time, s; null while the clip is written or read. */
  begin_s: number | null;
  seconds: number | null;
  why: string;
  cameras: { id: number; frames: number; missing: number }[];
  pinned: boolean;
  problem: string;
}

export interface Clips {
  last_seconds: LastSeconds;
  clip: ClipNow;
  /** How far back a clip reaches by the settings. */
  seconds: number;
  clips: Clip[];
}

export interface ClipEvent {
  /** Since the clip's beginning. */
  time_s: number;
  kind: string;
  text: string;
}

export interface ClipCamera {
  id: number;
  missing: number;
  /** Of each frame: how it is asked for, when it was taken since the beginning, and its number. */
  places: number[];
  times_s: number[];
  numbers: number[];
}

export interface ClipFrames {
  begin_s: number;
  seconds: number;
  why: string;
  site: string;
  version: string;
  events: ClipEvent[];
  cameras: ClipCamera[];
}

/** As it was sent; what is null the packet did not tell. */
export type RecordedRobot = Omit<Robot, 'id' | 'orientation'> & { id: number | null; orientation: number | null };

export interface ClipFrame {
  camera: number;
  number: number;
  time_s: number;
  /** Of the camera's image, px. */
  width: number;
  height: number;
  robots: RecordedRobot[];
  balls: Ball[];
}

export type CompareWith = 'recorded_settings' | 'settings_now' | 'learnt_colors';

export interface Difference {
  place: number;
  time_s: number;
  kind: 'found' | 'lost' | 'moved' | 'id';
  /** "yellow 3", "ball" */
  what: string;
  by_mm: number;
  by_deg?: number;
  x_mm: number;
  y_mm: number;
  pixel_x: number;
  pixel_y: number;
}

export interface ComparisonResult {
  exact: boolean;
  why_not_exact: string;
  frames: number;
  frames_that_differ: number;
  found: number;
  lost: number;
  moved: number;
  id_changed?: number;
  largest_mm: number;
  threshold_mm: number;
  differences: Difference[];
}

export interface Comparison {
  state: 'idle' | 'running' | 'done' | 'failed';
  clip: string;
  camera: number;
  with: CompareWith;
  done: number;
  frames: number;
  error: string;
  result: ComparisonResult | null;
}

export interface LogRobot { team: Team; id: number | null; x: number; y: number; orientation: number | null }
export interface LogTrackedRobot extends LogRobot { vx?: number | null; vy?: number | null }

/** What a log knows of one moment: the newest of each source that is not old. */
export interface LogMoment {
  time_s: number;
  cameras: { id: number; time_s: number; robots: LogRobot[]; balls: { x: number; y: number }[] }[];
  tracked: { robots: LogTrackedRobot[]; ball: { x: number; y: number; z?: number | null; vx?: number | null; vy?: number | null } | null } | null;
  referee: { stage: string; command: string; yellow: { name: string; score: number }; blue: { name: string; score: number } } | null;
  field: { length: number; width: number } | null;
}
