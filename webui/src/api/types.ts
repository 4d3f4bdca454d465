// SPDX-License-Identifier: Apache-2.0
// The daemon's objects by short names. What is in them comes from docs/openapi.json, by `npm run types`.
import type { components } from './schema';

type Schemas = components['schemas'];

export type FieldSize = Schemas['FieldSize'];
export type Calibration = Schemas['CalibrationInForce'];
export type Stage = Schemas['Stage'];
export type CameraStatus = Schemas['CameraStatus'];
export type CameraState = CameraStatus['state'];
export type NetworkStatus = Schemas['NetworkStatus'];
export type NetworkInterface = Schemas['NetworkInterface'];
export type OtherVision = Schemas['OtherVision'];
export type TeamStatus = Schemas['TeamStatus'];
export type Alert = Schemas['Alert'];
export type Severity = Alert['severity'];
export type Status = Schemas['Status'];
export type Robot = Schemas['Robot'];
export type Team = Robot['team'];
export type Ball = Schemas['Ball'];
export type Detections = Schemas['Detections'];
export type PictureKind = Schemas['PictureKind'];
export type PreviewHeader = Schemas['PreviewHeader'];
export type PreviewRequest = Required<Schemas['PreviewRequest']>;

export type SettingsRevision = Schemas['SettingsRevision'];
export type SettingsStep = Schemas['SettingsStep'];
export type SettingsChange = Schemas['SettingsChange'];
export type Stale = Schemas['Stale'];
export type Control = Schemas['Control'];
export type FieldPreset = Schemas['FieldPreset'];

export type Topic = 'status' | 'detections';

export type ClientMessage =
  | { subscribe: Topic[] }
  | { preview: PreviewRequest }
  | { ack: { camera: number; frame: number } }
  | { stop_preview: number };
