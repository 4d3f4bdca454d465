// SPDX-License-Identifier: Apache-2.0
// Objects for tests only.
import type { CameraStatus, FieldSize, Robot, Status } from '../api/types';

export const divisionB: FieldSize = {
  field_length: 9000, field_width: 6000, goal_width: 1000, goal_depth: 180, boundary_width: 300,
  penalty_area_depth: 1000, penalty_area_width: 2000, center_circle_radius: 500, line_thickness: 10,
  goal_center_to_penalty_mark: 6000, ball_radius: 21.5, max_robot_radius: 90,
};

export function camera(changes: Partial<CameraStatus> = {}): CameraStatus {
  return {
    id: 0, name: '+x half', backend: 'simulator', origin: 'simulation', state: 'running', error: '', width: 780, height: 580, pixel_format: 'uyvy',
    fps: 60, frames: 7200, frames_dropped: 0, frames_incomplete: 0, frames_capped: 0, packets: null, reconnects: 0, controls_unsaved: 0,
    latency_ms: { p50: 0.6, p99: 0.9 }, age_ms: { p50: 3.1, p99: 3.4 }, t_capture_from: 'camera', t_capture_sigma_ms: 0.05, stages: [], hangs: null, robots: 6, balls: 1,
    calibration: {
      focal_length: 600, principal_point_x: 390, principal_point_y: 290, distortion: 0.1,
      q0: 0.7071, q1: -0.7071, q2: 0, q3: 0, tx: 0, ty: 1250, tz: 3500, pixel_image_width: 780, pixel_image_height: 580,
      derived_camera_world_tx: 1250, derived_camera_world_ty: 0, derived_camera_world_tz: 3500,
    },
    ...changes,
  };
}

export function status(changes: Partial<Status> = {}): Status {
  return {
    version: '1.0.0', site: 'Demo field', time: 1790000000, uptime_s: 60, field: divisionB,
    network: { group: '224.5.23.2', port: 10006, interface: 'lo', error: '', packets_sent: 1234, send_errors: 0, packets_per_s: 121, packets_refused: 0, other_visions: [] },
    referee: {
      enabled: true, group: '224.5.23.1', port: 10003, error: '', source: '', address: '', other: null, silent_s: null,
      game_is_running: false, match: null, packets_refused: 0,
    },
    teams: { yellow: { name: '', robot_height: 140, height_from: 'settings' }, blue: { name: '', robot_height: 140, height_from: 'settings' } },
    settings_revision: 1, viewers: 1, alerts: [], go: true, checks: [{ id: 'cameras', title: 'Cameras', state: 'pass', value: '2', unit: 'of 2', text: '2 of 2 running, 60.0 frames/s' }],
    match_since: null,
    panel: { port: 8090, addresses: [] },
    coverage: { grid_mm: 250, uncovered: [] },
    cameras: [camera(), camera({ id: 1, name: '-x half' })],
    tracks: { stages: [], hangs: null },
    ...changes,
  };
}

export function robot(changes: Partial<Robot> = {}): Robot {
  return { team: 'yellow', id: 0, x: 0, y: 0, orientation: 0, height: 140, confidence: 0.9, pixel_x: 0, pixel_y: 0, ...changes };
}
