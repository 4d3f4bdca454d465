// SPDX-License-Identifier: Apache-2.0
// A camera's colour table on the service, and pending edits. The page shows a stroke at once and replaces it with the
// service's table when that arrives; until then, the stroke has no effect.
import { onUnmounted, ref, shallowRef, triggerRef, watch } from 'vue';
import { api, messageOf } from '../../api/client';
import type { ColorCommand, ColorEdited, ColorState } from '../../api/types';
import { knownStatus } from '../../state/live';
import { valueAt } from '../../settings/pointer';
import { cameraIndex, showSaving, useSettings } from '../../state/settings';
import { paint, strokeCommands, type Brush, type Cell } from './brush';
import { decodeTable, type Table } from './table';

/** Maximum number of commands per request. */
const MOST_COMMANDS = 200;
/** Polling interval while the light is followed, or margins are unknown. */
const LIGHT_MS = 2000;
/** Margins also change with the camera's view, so they are polled at least once per this many intervals. */
const MARGINS_EVERY = 5;

interface Stroke {
  brush: Brush;
  label: { name: string; value: number } | null;
  cells: Cell[];
}

export function useColours(camera: number) {
  const path = `cameras/${camera}/colors`;
  const state = shallowRef<ColorState | null>(null);
  /** The table of the service. */
  const table = shallowRef<Table | null>(null);
  /** The same with strokes that the service has not confirmed. */
  const painted = shallowRef<Table | null>(null);
  /** Why the table cannot be shown. */
  const trouble = ref('');
  /** Why the last edit failed. */
  const refusal = ref('');
  let alive = true;

  let strokes: Stroke[] = [];
  let tableRevision = -1;
  let fetching = false;

  const apply = (onto: Table, { brush, label, cells }: Stroke) => { for (const cell of cells) paint(onto, brush, cell, label?.value ?? 0); };
  function repaint(): void {
    if (!table.value) return;
    painted.value = strokes.length ? { bits: table.value.bits, labels: table.value.labels.slice() } : table.value;
    for (const stroke of strokes) apply(painted.value, stroke);
  }

  async function fetchTable(): Promise<void> {
    if (fetching) return;
    fetching = true;
    try {
      while (alive && state.value && tableRevision !== state.value.revision) {
        const { revision } = state.value;
        table.value = decodeTable(await (await api.blob(`${path}/table`)).arrayBuffer());
        tableRevision = revision;
        repaint();
      }
      trouble.value = '';
    } catch (error) {
      trouble.value = `The table cannot be shown: ${messageOf(error)}`;
    } finally {
      fetching = false;
    }
  }

  function take(next: ColorState): Promise<void> {
    // Answers may arrive out of order; a restarted service begins with a lower revision, which load() accepts.
    if (!state.value || next.revision >= state.value.revision) state.value = next;
    return fetchTable();
  }

  async function load(): Promise<void> {
    const before = state.value;
    try {
      const next = await api.get<ColorState>(path);
      if (!alive) return;
      // An edit's answer that arrived meanwhile may be newer.
      if (!state.value || state.value === before || next.revision >= state.value.revision) state.value = next;
      trouble.value = '';
      await fetchTable();
    } catch (error) {
      trouble.value = messageOf(error);
    }
  }
  void load();
  // settings_revision also counts changes by other users.
  watch(() => knownStatus.value?.settings_revision, (now, before) => { if (before !== undefined && now !== before) void load(); });
  const { settings } = useSettings();
  // The service starts and stops following the light shortly after the setting changes.
  const isFollowed = () => settings.value !== null && valueAt(settings.value, `/cameras/${cameraIndex(camera)}/follow_light/enabled`) === true;
  let ticks = 0;
  const timer = setInterval(() => {
    if (state.value && (isFollowed() || state.value.light.state !== 'off' || state.value.margins === null || ++ticks % MARGINS_EVERY === 0)) void load();
  }, LIGHT_MS);
  onUnmounted(() => { alive = false; clearInterval(timer); });

  /** One at a time, so that each edit builds on the previous one. */
  let queue: Promise<unknown> = Promise.resolve();
  function inTurn<T>(work: () => Promise<T>): Promise<T | null> {
    const result = queue.then(async () => {
      refusal.value = '';
      try {
        return await showSaving(work);
      } catch (error) {
        refusal.value = messageOf(error);
        return null;
      }
    });
    queue = result;
    return result;
  }

  const change = (work: () => Promise<ColorState>) => inTurn(async () => {
    const next = await work();
    await take(next);
    return next;
  });

  const send = (commands: ColorCommand[]) => inTurn(async () => {
    const edited = await api.post<ColorEdited>(`${path}/edits`, { commands });
    await take(edited.state);
    return edited;
  });

  async function endStroke(stroke: Stroke): Promise<void> {
    if (table.value && stroke.cells.length) await send(strokeCommands(table.value, stroke.brush, stroke.cells, stroke.label?.name ?? null));
    strokes = strokes.filter((one) => one !== stroke);
    repaint();
  }

  return {
    state, table, painted, trouble, refusal,
    load,
    edit: send,
    undo: () => change(() => api.post<ColorState>(`${path}/undo`)),
    redo: () => change(() => api.post<ColorState>(`${path}/redo`)),
    reset: () => change(() => api.post<ColorState>(`${path}/reset`)),
    copyFrom: (from: number) => change(() => api.post<ColorState>(`${path}/copy`, { from })),
    revertLight: () => change(() => api.post<ColorState>(`${path}/light/revert`)),
    keepLight: () => change(() => api.post<ColorState>(`${path}/light/keep`)),
    /** Accepts the state from the answer of another request. */
    taken: take,
    /** Runs any other request that answers with the state. */
    change,
    /** Begins a brush stroke, which is one undo step. `label` null: erases. */
    stroke(brush: Brush, label: { name: string; value: number } | null) {
      let current: Stroke = { brush, label, cells: [] };
      strokes.push(current);
      const add = (cell: Cell) => {
        if (!table.value) return;
        if (painted.value === table.value) repaint();
        current.cells.push(cell);
        paint(painted.value!, brush, cell, label?.value ?? 0);
        if (current.cells.length < MOST_COMMANDS) return;
        void endStroke(current);
        current = { brush, label, cells: [] };
        strokes.push(current);
      };
      return {
        to(cells: Cell[]) {
          for (const cell of cells) add(cell);
          triggerRef(painted);
        },
        end: () => endStroke(current),
      };
    },
  };
}
export type Colours = ReturnType<typeof useColours>;
