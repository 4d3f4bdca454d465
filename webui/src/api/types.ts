// SPDX-License-Identifier: Apache-2.0
// The daemon's objects as docs/api.md gives them: millimetres, radians, seconds, pixels.

export interface FieldSize {
  field_length: number;
  field_width: number;
  goal_width: number;
  goal_depth: number;
  boundary_width: number;
  penalty_area_depth: number;
  penalty_area_width: number;
  center_circle_radius: number;
  line_thickness: number;
  goal_center_to_penalty_mark: number;
  ball_radius: number;
  max_robot_radius: number;
  /** What is painted, where that is not what the sizes say. */
  field_lines?: { name: string; x1: number; y1: number; x2: number; y2: number }[] | null;
  field_arcs?: { name: string; x: number; y: number; radius: number; a1: number; a2: number }[] | null;
}

export interface Calibration {
  focal_length: number;
  principal_point_x: number;
  principal_point_y: number;
  distortion: number;
  q0: number;
  q1: number;
  q2: number;
  q3: number;
  tx: number;
  ty: number;
  tz: number;
  derived_camera_world_tx: number;
  derived_camera_world_ty: number;
  derived_camera_world_tz: number;
}

export interface Stage {
  name: string;
  p50_us: number;
  p99_us: number;
}

export type CameraState = 'opening' | 'running' | 'lost' | 'ended';

export interface CameraStatus {
  id: number;
  name: string;
  backend: string;
  state: CameraState;
  error: string;
  width: number;
  height: number;
  pixel_format: string;
  fps: number;
  frames: number;
  frames_dropped: number;
  frames_incomplete: number;
  frames_capped: number;
  reconnects: number;
  latency_ms: { p50: number; p99: number };
  stages: Stage[];
  robots: number;
  balls: number;
  calibration: Calibration | null;
}

export interface NetworkStatus {
  group: string;
  port: number;
  interface: string;
  error: string;
  packets_sent: number;
  send_errors: number;
  packets_per_s: number;
}

export type Severity = 'bad' | 'warn' | 'info';

export interface Alert {
  severity: Severity;
  title: string;
  fix: string;
  /** Null when it is not about one camera. */
  camera?: number | null;
}

export interface Status {
  version: string;
  site: string;
  time: number;
  uptime_s: number;
  field: FieldSize;
  network: NetworkStatus;
  viewers: number;
  alerts: Alert[];
  cameras: CameraStatus[];
}

export type Team = 'yellow' | 'blue';

export interface Robot {
  team: Team;
  id: number;
  x: number;
  y: number;
  orientation: number;
  height: number;
  confidence: number;
  pixel_x: number;
  pixel_y: number;
}

export interface Ball {
  x: number;
  y: number;
  confidence: number;
  area: number;
  pixel_x: number;
  pixel_y: number;
}

export interface Detections {
  camera: number;
  frame: number;
  t_capture: number;
  robots: Robot[];
  balls: Ball[];
}

/** The camera's own picture, or what its colour table made of it. */
export type PictureKind = 'camera' | 'labels';

/** Header of a preview picture: the detections are those of this very frame. */
export interface PreviewHeader extends Detections {
  /** Not always the one asked for: where nothing is labelled the camera's comes. */
  picture: PictureKind;
  /** Size of the camera's picture, whichever comes. */
  width: number;
  height: number;
}

export interface PreviewRequest {
  camera: number;
  width: number;
  quality: number;
  fps: number;
  picture: PictureKind;
}

export type Topic = 'status' | 'detections';

export type ClientMessage =
  | { subscribe: Topic[] }
  | { preview: PreviewRequest }
  | { ack: { camera: number; frame: number } }
  | { stop_preview: number };
