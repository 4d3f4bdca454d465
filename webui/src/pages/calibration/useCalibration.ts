// SPDX-License-Identifier: Apache-2.0
// Calibrates one camera: sends points and known values to the service, and receives its report.
import { computed, ref, watch } from 'vue';
import type { CalibrationState, CameraStatus } from '../../api/types';
import { CameraModel, type Point } from '../../geometry/cameraModel';
import { linesPath } from '../../geometry/outline';
import { knownStatus } from '../../state/live';
import { clampInto, knownOf, knownText, NOTHING_KNOWN, pointsOf, requestOf, seenPoints, type Corner, type Known } from './points';
import { figures } from './figures';
import { useJob } from '../../state/useJob';
import { useOverlap } from './useOverlap';
import { useRefusable } from './useRefusable';

export type Step = 'points' | 'known' | 'run' | 'look' | 'history';

export function useCalibration(camera: () => CameraStatus) {
  const job = useJob<CalibrationState>(`cameras/${camera().id}/calibration`);
  const { state, running } = job;
  const report = computed(() => state.value?.report ?? null);
  const inUse = computed(() => state.value?.calibration ?? null);
  const { busy, refusal, attempt } = useRefusable();

  const points = ref<Corner[]>([]);
  const known = ref<Known>(NOTHING_KNOWN);
  const selected = ref(-1);
  const chosen = ref<Step | null>(null);
  const automatic = computed<Step>(() => {
    if (running.value || state.value?.state === 'failed') return 'run';
    return report.value ? 'look' : 'points';
  });
  const step = computed(() => chosen.value ?? automatic.value);

  const asText = (list: Corner[]) => JSON.stringify(list);
  const reported = computed(() => (report.value ? pointsOf(report.value, camera()) : []));
  /** Whether the points were changed after the report. */
  const changed = computed(() => report.value !== null && asText(points.value) !== asText(reported.value));

  // A job of this or any other browser began or ended: show its points.
  watch(() => state.value && `${state.value.started} ${state.value.state}`, (_, before) => {
    if (!state.value) return;
    const { request } = state.value;
    if (report.value) {
      points.value = reported.value;
      selected.value = -1;
    } else if (request && before === null) {
      points.value = (request.points ?? []).map(({ x, y, name }) => ({ x, y, name: name ?? '' }));
    }
    if (request && (before === null || running.value)) known.value = knownOf(request);
    if (request) chosen.value = null;
  });

  /** The report's doubts about each point, unless the point was moved since. */
  const doubts = computed(() => points.value.map((point, i) => {
    const said = report.value?.points[i];
    const same = said && asText([reported.value[i]!]) === asText([point]);
    return same && said.suspect ? `${figures(said.off_px)} px from ${said.name || 'any point of the field'}: drag it there` : '';
  }));
  /** RMS distance between the points and their positions according to the new calibration, px. */
  const pointsOff = computed(() => {
    const list = report.value?.points ?? [];
    return list.length ? Math.sqrt(list.reduce((sum, { off_px }) => sum + off_px * off_px, 0) / list.length) : null;
  });

  const start = (withPoints: boolean) => attempt('Calibrate anyway', async (force) => {
    await job.start(requestOf(withPoints ? points.value : [], known.value, force));
    chosen.value = null;
  });
  const forceable = () => report.value?.found === true;

  const linesOf = (calibration: CalibrationState['calibration']) => (calibration && knownStatus.value
    ? linesPath(new CameraModel(calibration), camera(), 0, knownStatus.value.field) : '');
  // Compared by value: polling returns equal calibrations repeatedly.
  const inUseText = computed(() => JSON.stringify(inUse.value));
  const foundText = computed(() => JSON.stringify(report.value?.calibration ?? null));
  const linesInUse = computed(() => linesOf(JSON.parse(inUseText.value)));
  const linesFound = computed(() => linesOf(JSON.parse(foundText.value)));

  return {
    job, state, running, report, inUse, busy, refusal, step, points, known, selected, doubts, changed, pointsOff, linesInUse, linesFound,
    knownWords: computed(() => knownText(known.value)),
    overlap: useOverlap(camera().id, () => inUse.value, () => report.value?.calibration ?? null),
    /** The record of the calibration in use; null if the calibration has been changed by other means since. */
    record: computed(() => {
      const newest = state.value?.history.find(({ reverted }) => reverted === null);
      return newest && JSON.stringify(newest.calibration) === inUseText.value ? newest : null;
    }),
    go(to: Step) { chosen.value = to; refusal.value = null; },
    find: () => start(false),
    run: () => start(true),
    cancel: () => attempt('', () => job.cancel()),
    accept: async () => {
      if (await attempt('Use it anyway', job.accept, forceable)) chosen.value = 'history';
    },
    reject: async () => {
      if (await attempt('', () => job.reject())) chosen.value = 'points';
    },
    revert: () => attempt('Revert anyway', job.revert, () => state.value?.history.some(({ reverted }) => reverted === null) ?? false),
    propose() {
      if (inUse.value) points.value = seenPoints(new CameraModel(inUse.value), state.value!.points, camera());
    },
    add(at: Point) {
      points.value = [...points.value, { ...clampInto(at, camera()), name: '' }];
      selected.value = points.value.length - 1;
    },
    move(index: number, to: Point) {
      points.value = points.value.map((point, i) => (i === index ? { ...point, ...clampInto(to, camera()) } : point));
    },
    name(index: number, name: string) {
      points.value = points.value.map((point, i) => (i === index ? { ...point, name } : point));
    },
    remove(index: number) {
      points.value = points.value.filter((_, i) => i !== index);
      selected.value = -1;
    },
    clear() { points.value = []; selected.value = -1; },
  };
}
