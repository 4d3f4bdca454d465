// SPDX-License-Identifier: Apache-2.0
// Short names for the daemon's objects, which `npm run types` generates from docs/openapi.json.
import type { components } from './schema';

type Schemas = components['schemas'];

export type FieldSize = Schemas['FieldSize'];
export type Calibration = Schemas['CalibrationInForce'];
export type Stage = Schemas['Stage'];
export type CameraStatus = Schemas['CameraStatus'];
export type CameraState = CameraStatus['state'];
export type NetworkStatus = Schemas['NetworkStatus'];
export type NetworkInterface = Schemas['NetworkInterface'];
export type SentPackets = Schemas['SentPackets'];
export type HeardDetection = SentPackets['detections'][number];
export type HeardGeometry = NonNullable<SentPackets['geometry']>;
export type DetectionRobot = Schemas['DetectionRobot'];
export type Listeners = Schemas['Listeners'];
export type OtherVision = Schemas['OtherVision'];
export type TeamStatus = Schemas['TeamStatus'];
export type Alert = Schemas['Alert'];
export type AlertId = Schemas['AlertId'];
export type Severity = Alert['severity'];
export type Check = Schemas['Check'];
export type Timeline = Schemas['Timeline'];
export type PacketTimeline = Schemas['PacketTimeline'];
export type CameraTimeline = Schemas['CameraTimeline'];
export type Diagnostics = Schemas['Diagnostics'];
export type Histogram = Schemas['Histogram'];
export type Events = Schemas['Events'];
export type EventEntry = Schemas['EventEntry'];
export type LogLevel = Schemas['LogLevel'];
export type LogLines = Schemas['LogLines'];
export type LogLine = LogLines['lines'][number];
export type Status = Schemas['Status'];
export type Robot = Schemas['Robot'];
export type Team = Robot['team'];
export type Ball = Schemas['Ball'];
export type Detections = Schemas['Detections'];
export type TrackedRobot = Schemas['TrackedRobot'];
export type TrackedBall = Schemas['TrackedBall'];
export type BallLearning = Schemas['BallLearning'];
export type FieldTracks = Schemas['FieldTracks'];
export type FieldNow = Schemas['FieldNow'];
export type FieldAgreement = Schemas['FieldAgreement'];
export type AgreementTrend = FieldAgreement['trends'][number];
export type FieldDifference = FieldAgreement['differences'][number];
export type FieldKick = Schemas['FieldKick'];
export type FieldKicks = Schemas['FieldKicks'];
export type PictureKind = Schemas['PictureKind'];
export type PreviewHeader = Schemas['PreviewHeader'];
export type PreviewRegions = Schemas['PreviewRegions'];
export type PreviewRequest = Required<Omit<Schemas['PreviewRequest'], 'regions'>> & Pick<Schemas['PreviewRequest'], 'regions'>;
export type ProfileEntry = Schemas['ProfileEntry'];
export type Profile = Schemas['Profile'];

export type BackupContents = Schemas['BackupContents'];
export type RestoredBackup = Schemas['RestoredBackup'];

export type Recordings = Schemas['Recordings'];
export type MatchLogNow = Schemas['MatchLogNow'];
export type MatchLog = Schemas['MatchLog'];
export type MatchLogEvents = Schemas['MatchLogEvents'];
export type MatchLogEvent = Schemas['MatchLogEvent'];
export type * from './clips';

export type Session = Schemas['Session'];
export type SettingsRevision = Schemas['SettingsRevision'];
export type SettingsStep = Schemas['SettingsStep'];
export type SettingsChange = Schemas['SettingsChange'];
export type Stale = Schemas['Stale'];
export type Control = Schemas['Control'];
export type FieldPreset = Schemas['FieldPreset'];
export type FoundSource = Schemas['Source'];
export type FileList = Schemas['FileList'];
export type UploadedImages = Schemas['UploadedImages'];

export type CameraGeometry = Schemas['Calibration'];
export type CalibrationRequest = Schemas['CalibrationRequest'];
export type CalibrationReport = Schemas['CalibrationReport'];
export type CalibrationRecord = Schemas['CalibrationRecord'];
export type CalibrationState = Schemas['CalibrationState'];
export type FieldPoint = CalibrationState['points'][number];
export type JointCalibrationReport = Schemas['JointCalibrationReport'];
export type JointCalibrationState = Schemas['JointCalibrationState'];

export type ColorState = Schemas['ColorState'];
export type ColorMargin = Schemas['ColorMargin'];
export type ColorLabel = Schemas['ColorLabel'];
export type ColorStep = Schemas['ColorStep'];
export type ColorCommand = Schemas['ColorCommand'];
export type ColorEdited = Schemas['ColorEdited'];
export type ColorImport = Schemas['ColorImport'];
export type LightState = Schemas['LightState'];
export type Still = Schemas['Still'];
export type FieldView = Schemas['FieldView'];
export type Pixels = Schemas['Pixels'];
export type LearningState = Schemas['LearningState'];
export type LearningReport = Schemas['LearningReport'];
export type LearningPicture = Schemas['LearningPicture'];
export type LearningDetections = Schemas['LearningDetections'];
export type LearningGuide = NonNullable<Schemas['LearningRequest']['guide']>[number];

export type Topic = 'status' | 'detections' | 'field';

export type ClientMessage =
  | { subscribe: Topic[] }
  | { unsubscribe: Topic[] }
  | { preview: PreviewRequest }
  | { ack: { camera: number; frame: number } }
  | { stop_preview: number };
