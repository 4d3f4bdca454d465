// SPDX-License-Identifier: Apache-2.0
// Layout of the camera tiles: in the order of the cameras over the field, if it is known.
import type { CameraStatus, FieldSize } from '../api/types';

export interface Place {
  camera: number;
  column: number;
  row: number;
}

export interface Mosaic {
  columns: number;
  rows: number;
  places: Place[];
}

/** Ranks positions; positions closer than `gap` share a rank. */
function ranks(values: number[], gap: number): Map<number, number> {
  const sorted = [...values].sort((p, q) => p - q);
  const result = new Map<number, number>();
  let rank = 0;
  sorted.forEach((value, i) => {
    if (i > 0 && value - sorted[i - 1]! > gap) rank++;
    result.set(value, rank);
  });
  return result;
}

function byNumber(cameras: CameraStatus[]): Mosaic {
  const columns = cameras.length <= 1 ? 1 : cameras.length <= 4 ? 2 : Math.ceil(cameras.length / 2);
  const places = [...cameras]
    .sort((p, q) => p.id - q.id)
    .map((camera, i) => ({ camera: camera.id, column: i % columns, row: Math.floor(i / columns) }));
  return { columns, rows: Math.max(1, Math.ceil(cameras.length / columns)), places };
}

/** Cameras closer together than this share of the field hang in the same row or column. */
const SAME = 0.12;

export function mosaic(cameras: CameraStatus[], field: FieldSize): Mosaic {
  if (cameras.length < 2 || cameras.some((camera) => !camera.calibration)) return byNumber(cameras);
  const at = cameras.map((camera) => ({
    camera: camera.id,
    x: camera.calibration!.derived_camera_world_tx,
    y: camera.calibration!.derived_camera_world_ty,
  }));
  const columns = ranks(at.map((p) => p.x), field.field_length * SAME);
  const rows = ranks(at.map((p) => -p.y), field.field_width * SAME);
  const places = at.map((p) => ({ camera: p.camera, column: columns.get(p.x)!, row: rows.get(-p.y)! }));
  const count = { columns: Math.max(...columns.values()) + 1, rows: Math.max(...rows.values()) + 1 };
  const distinct = new Set(places.map((p) => `${p.column} ${p.row}`)).size;
  // Two cameras in one place, or a grid with gaps: the calibrations give no useful order.
  if (distinct < cameras.length || count.columns * count.rows > cameras.length) return byNumber(cameras);
  places.sort((p, q) => p.row - q.row || p.column - q.column);
  return { ...count, places };
}
