// SPDX-License-Identifier: Apache-2.0
// A camera's calibration, prepared for printing.
import type { Calibration, CalibrationRecord, CalibrationReport, CalibrationState } from '../../../api/types';
import { clockTime, decimal } from '../../../format';
import { figures } from '../figures';
import { lineTitle, pointTitle } from '../names';

type Lines = CalibrationReport['lines'];
type Points = CalibrationReport['points'];

/** The record of the calibration in use; null if it was made elsewhere or by an older service. */
export function recordInUse(state: CalibrationState): CalibrationRecord | null {
  const newest = state.history.find(({ reverted }) => reverted === null);
  return newest && JSON.stringify(newest.calibration) === JSON.stringify(state.calibration) ? newest : null;
}

export interface Row {
  label: string;
  value: string;
}

const NONE = '–';
const of = (record: CalibrationRecord | null, key: string) => figures(record?.figures[key] as number | null | undefined) ?? NONE;
const share = (record: CalibrationRecord | null, key: string) => {
  const value = record?.figures[key];
  return typeof value === 'number' ? `${Math.round(100 * value)} %` : NONE;
};

export const figureRows = (record: CalibrationRecord | null): Row[] => [
  { label: 'Expected error on the floor', value: `${of(record, 'expected_on_floor_mm')} mm` },
  { label: 'Expected error at 150 mm height', value: `${of(record, 'expected_at_150_mm')} mm` },
  { label: 'Reprojection of the lines, RMS', value: `${of(record, 'rms_px')} px, ${of(record, 'rms_mm')} mm` },
  { label: 'Reprojection of the lines, worst', value: `${of(record, 'worst_px')} px, ${of(record, 'worst_mm')} mm` },
  { label: 'Image covered by the lines', value: share(record, 'coverage') },
  { label: 'Painted lines found', value: share(record, 'found_share') },
  { label: 'Height of the camera', value: `${of(record, 'height_mm')} mm, accurate to ${of(record, 'height_sigma_mm')} mm` },
];

export const modelRows = (model: Calibration): Row[] => [
  { label: 'Image', value: `${model.pixel_image_width} × ${model.pixel_image_height} px` },
  { label: 'Focal length', value: `${decimal(model.focal_length, 2)} px` },
  { label: 'Principal point', value: `${decimal(model.principal_point_x, 2)}, ${decimal(model.principal_point_y, 2)} px` },
  { label: 'Distortion', value: decimal(model.distortion, 5) },
  { label: 'Camera at x, y, height', value: `${[model.derived_camera_world_tx, model.derived_camera_world_ty, model.derived_camera_world_tz].map((mm) => decimal(mm ?? 0, 0)).join(', ')} mm` },
  { label: 'Rotation q0, q1, q2, q3', value: [model.q0, model.q1, model.q2, model.q3].map((q) => decimal(q, 5)).join(', ') },
];

const list = <T>(record: CalibrationRecord | null, key: string) => (Array.isArray(record?.figures[key]) ? record.figures[key] as T : null);

/** One row per line: name, pieces found, px, mm. Null: not recorded. */
export const lineTable = (record: CalibrationRecord | null) => list<Lines>(record, 'lines')?.map((line) => ({
  name: lineTitle(line.name), found: `${line.patches} of ${line.expected}`, px: figures(line.rms_px) ?? NONE, mm: figures(line.rms_mm) ?? NONE,
})) ?? null;
export const pointTable = (record: CalibrationRecord | null) => list<Points>(record, 'points')?.map((point) => ({
  name: point.name ? pointTitle(point.name) : 'unnamed', px: figures(point.off_px) ?? NONE,
})) ?? null;

export const historyRows = (records: CalibrationRecord[]) => records.map((record) => ({
  key: record.time, when: clockTime(record.time), who: record.who || 'somebody', rms: of(record, 'rms_px'), error: of(record, 'expected_on_floor_mm'),
  end: record.reverted === null ? '' : `reverted ${clockTime(record.reverted)} by ${record.reverted_by || 'somebody'}`,
}));
