// SPDX-License-Identifier: Apache-2.0
// The league's camera model: quaternion (x, y, z, w) and translation transform field to camera coordinates; the camera
// looks along +z; one radial distortion term. Pixel centres are integers.
import type { CameraGeometry } from '../api/types';

export interface Point {
  x: number;
  y: number;
}

export interface Point3 extends Point {
  z: number;
}

type Matrix = readonly [number, number, number, number, number, number, number, number, number];

function rotation(c: CameraGeometry): Matrix {
  const { q0: x, q1: y, q2: z, q3: w } = c;
  // Published quaternions are rounded: normalise, so that the matrix is a rotation.
  const s = 2 / (x * x + y * y + z * z + w * w);
  return [
    1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
    s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),
    s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y),
  ];
}

/** Solves ru = rd (1 + d rd²) for rd. Null beyond the radius where a negative d folds the image over. */
export function distortRadius(ru: number, d: number): number | null {
  if (d === 0 || ru === 0) return ru;
  const turning = d < 0 ? 1 / Math.sqrt(-3 * d) : Infinity;
  if (d < 0 && ru >= turning * (1 + d * turning * turning)) return null;
  let rd = Math.min(ru, turning * 0.999);
  for (let step = 0; step < 30; step++) {
    const change = (rd * (1 + d * rd * rd) - ru) / (1 + 3 * d * rd * rd);
    rd = Math.min(rd - change, turning);
    if (Math.abs(change) < 1e-12) break;
  }
  return rd;
}

export class CameraModel {
  private readonly r: Matrix;
  /** Camera position in field coordinates, mm. */
  readonly position: Point3;

  constructor(private readonly c: CameraGeometry) {
    const r = (this.r = rotation(c));
    this.position = {
      x: -(r[0] * c.tx + r[3] * c.ty + r[6] * c.tz),
      y: -(r[1] * c.tx + r[4] * c.ty + r[7] * c.tz),
      z: -(r[2] * c.tx + r[5] * c.ty + r[8] * c.tz),
    };
  }

  /** Projects a field point, mm, to a pixel; null if it is behind the camera or beyond the lens model's range. */
  project(x: number, y: number, z: number): Point | null {
    const { r, c } = this;
    const pz = r[6] * x + r[7] * y + r[8] * z + c.tz;
    if (pz <= 1) return null;
    const ux = (r[0] * x + r[1] * y + r[2] * z + c.tx) / pz;
    const uy = (r[3] * x + r[4] * y + r[5] * z + c.ty) / pz;
    const ru = Math.hypot(ux, uy);
    const rd = distortRadius(ru, c.distortion);
    if (rd === null) return null;
    const scale = c.focal_length * (ru > 0 ? rd / ru : 1);
    return { x: ux * scale + c.principal_point_x, y: uy * scale + c.principal_point_y };
  }

  /** Intersects a pixel's ray with the plane z = height; null if they do not meet. */
  unproject(pixelX: number, pixelY: number, height: number): Point | null {
    const { r, c, position } = this;
    const dx = (pixelX - c.principal_point_x) / c.focal_length;
    const dy = (pixelY - c.principal_point_y) / c.focal_length;
    const k = 1 + c.distortion * (dx * dx + dy * dy);
    const ux = dx * k;
    const uy = dy * k;
    const wz = r[2] * ux + r[5] * uy + r[8];
    const reach = (height - position.z) / wz;
    if (!(reach > 0) || !Number.isFinite(reach)) return null;
    return {
      x: position.x + reach * (r[0] * ux + r[3] * uy + r[6]),
      y: position.y + reach * (r[1] * ux + r[4] * uy + r[7]),
    };
  }
}
