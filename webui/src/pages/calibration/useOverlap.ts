// SPDX-License-Identifier: Apache-2.0
// Finds robots in live detections that this camera and another one see.
import { onUnmounted, shallowRef, watch } from 'vue';
import type { CameraGeometry, Detections } from '../../api/types';
import { CameraModel } from '../../geometry/cameraModel';
import { watchDetections } from '../../state/live';
import { median, meetings, type Meeting, type Pictures } from './overlap';

export interface Overlap {
  /** The other camera with the most meetings. */
  camera: number;
  meetings: number;
  /** Medians, mm. */
  inUse: number;
  proposed: number | null;
}

const MOST_MEETINGS = 300;
const OWN_PICTURES = 12;

export function useOverlap(camera: number, inUse: () => CameraGeometry | null, proposal: () => CameraGeometry | null) {
  const overlap = shallowRef<Overlap | null>(null);
  let all: Meeting[] = [];
  let own: Detections[] = [];
  const others = new Map<number, Pictures>();

  function summary(): Overlap | null {
    const counts = new Map<number, number>();
    for (const { camera: other } of all) counts.set(other, (counts.get(other) ?? 0) + 1);
    const most = [...counts].sort(([, a], [, b]) => b - a)[0]?.[0];
    if (most === undefined) return null;
    const theirs = all.filter(({ camera: other }) => other === most);
    return {
      camera: most, meetings: theirs.length, inUse: median(theirs.map((meeting) => meeting.inUse))!,
      proposed: median(theirs.flatMap((meeting) => meeting.proposed ?? [])),
    };
  }

  // Compared by value: polling returns equal calibrations repeatedly.
  watch(() => JSON.stringify([inUse(), proposal()]), () => { all = []; overlap.value = null; });

  const stop = watchDetections((picture) => {
    if (!inUse()) return;
    if (picture.camera === camera) {
      own = [...own.slice(1 - OWN_PICTURES), picture];
      return;
    }
    const pictures = { older: others.get(picture.camera)?.newer ?? null, newer: picture };
    others.set(picture.camera, pictures);
    const found = proposal();
    const model = found && new CameraModel(found);
    const met = own.flatMap((mine) => (pictures.older && mine.t_capture > pictures.older.t_capture ? meetings(mine, pictures, model) : []));
    if (!met.length) return;
    all = [...all, ...met].slice(-MOST_MEETINGS);
    overlap.value = summary();
  });
  onUnmounted(stop);
  return overlap;
}
