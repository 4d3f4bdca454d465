// SPDX-License-Identifier: Apache-2.0
// The service's settings tree, and pending changes. A change counts once the service confirms that it is on disk; one
// based on an older revision is only sent again if nobody else changed the same setting.
import { ref, shallowRef, watch } from 'vue';
import { api, ApiError, messageOf } from '../api/client';
import type { RestoredBackup, SettingsChange, SettingsRevision, SettingsStep, Stale } from '../api/types';
import { isEqual, overlap, setOperations, valueAt, type Json, type Operation } from '../settings/pointer';
import type { SchemaNode } from '../settings/schema';
import { knownStatus } from './live';

/** null until loaded. */
export const settings = shallowRef<Json | null>(null);
export const revision = ref(0);
/** Version of the settings' format, which is written to exports. */
export const version = ref(1);
export const schema = shallowRef<SchemaNode | null>(null);
/** Why loading failed. */
export const loadError = ref('');

export type SaveState =
  | { kind: 'idle' }
  | { kind: 'saving' }
  | { kind: 'saved'; at: Date }
  | { kind: 'failed'; text: string };
export const saveState = ref<SaveState>({ kind: 'idle' });

export type Outcome =
  /** `revision`: of the new step, if any. `refused`: parts that cameras did not accept, if any. */
  | { kind: 'saved'; revision?: number; refused?: readonly string[] }
  /** Invalid; `text` says why. The old settings stay. */
  | { kind: 'refused'; text: string }
  /** Another user changed the same setting meanwhile: the newest such step. */
  | { kind: 'stale'; step: SettingsStep }
  /** The service could not be reached, or could not save. */
  | { kind: 'failed'; text: string };

/** Follows the panel to another port, unless it was opened through a third one. Of port 0, any free one, this is not known. */
function followPanel(before: Json, after: Json): void {
  const [from, to] = [before, after].map((tree) => valueAt(tree, '/panel/port'));
  if (to !== from && typeof to === 'number' && to > 0 && (from === 0 || from === Number(location.port || (location.protocol === 'https:' ? 443 : 80)))) location.port = String(to);
}

function take(answer: SettingsRevision): void {
  if (answer.revision < revision.value) return;
  if (settings.value) followPanel(settings.value, answer.settings as Json);
  settings.value = answer.settings as Json;
  version.value = answer.version;
  revision.value = answer.revision;
}

let loading: Promise<void> | null = null;

/** Loads settings and schema; concurrent calls share one request. */
export function loadSettings(): Promise<void> {
  loading ??= (async () => {
    const before = revision.value;
    try {
      const [answer, newSchema] = await Promise.all([
        api.get<SettingsRevision>('settings'),
        schema.value ?? api.get<SchemaNode>('schema'),
      ]);
      schema.value = newSchema;
      // A restarted service may count from an older revision; but an answer overtaken by a newer one is outdated.
      if (revision.value === before) revision.value = 0;
      take(answer);
      loadError.value = '';
    } catch (error) {
      loadError.value = messageOf(error);
    } finally {
      loading = null;
    }
  })();
  return loading;
}

/** For components: the tree, which is loaded if necessary and follows the changes of others. */
export function useSettings() {
  if (!settings.value) void loadSettings();
  return { settings, schema, revision, loadError };
}
watch(knownStatus, (status, before) => {
  const newest = status?.settings_revision;
  if (!settings.value || newest === undefined || newest === revision.value || saveState.value.kind === 'saving') return;
  // Checked with every status: the last load or save may have been answered before the newest step. A lower revision
  // means a late status; a decreasing one means a restarted service.
  if (newest > revision.value || newest !== before?.settings_revision) void loadSettings();
});

interface OwnStep {
  revision: number;
  /** Paths of its changes. */
  paths: string[];
}
/** Steps of this browser that can be undone, newest last. */
const ownSteps = ref<OwnStep[]>([]);
const isBelow = (places: string[]) => ({ paths }: OwnStep) => paths.every((path) => places.some((place) => path === place || path.startsWith(`${place}/`)));
/** The newest of those that changed nothing outside these places. */
const lastOwn = (places: string[]) => ownSteps.value.filter(isBelow(places)).at(-1);
export const canUndo = (places = ['']) => lastOwn(places) !== undefined;

/** One change at a time, so that each builds on the previous one. */
let queue: Promise<unknown> = Promise.resolve();
function inTurn<T>(work: () => Promise<T>): Promise<T> {
  const result = queue.then(work);
  queue = result.catch(() => {});
  return result;
}

async function attempt(work: () => Promise<Outcome>): Promise<Outcome> {
  saveState.value = { kind: 'saving' };
  let outcome: Outcome;
  try {
    outcome = await work();
  } catch (error) {
    const refused = error instanceof ApiError && error.status >= 400 && error.status < 500;
    outcome = { kind: refused ? 'refused' : 'failed', text: messageOf(error) };
  }
  if (outcome.kind === 'saved') saveState.value = { kind: 'saved', at: new Date() };
  else saveState.value = outcome.kind === 'failed' ? outcome : { kind: 'idle' };
  return outcome;
}

/** Shows a request that saves by other means as a change of the settings, with its outcome. Rethrows its errors. */
export async function showSaving<T>(work: () => Promise<T>): Promise<T> {
  saveState.value = { kind: 'saving' };
  try {
    const result = await work();
    saveState.value = { kind: 'saved', at: new Date() };
    return result;
  } catch (error) {
    saveState.value = { kind: 'idle' };
    throw error;
  }
}

const touches = (step: SettingsStep, operations: Operation[]) =>
  step.changes.some(({ path }) => operations.some((operation) => overlap(path, operation.path)));

const sameRevision = () => ({ 'If-Match': String(revision.value) });

function takeOwn(answer: SettingsRevision, paths: string[], joins = false): Outcome {
  const isNew = answer.revision !== revision.value;
  if (isNew) {
    // The service merged it into the previous step, which changed the same setting: that step no longer exists.
    const last = ownSteps.value.at(-1);
    if (joins && last?.revision === revision.value && last.paths.join() === paths.join()) ownSteps.value.pop();
    ownSteps.value.push({ revision: answer.revision, paths });
  }
  take(answer);
  return { kind: 'saved', ...(isNew && { revision: answer.revision }), ...(answer.refused?.length && { refused: answer.refused }) };
}

/**
 * Cameras are addressed by their index in the list, where another camera may be when a change arrives: restricts the
 * change to the camera at that index in this tree.
 */
function sameCameras(tree: Json | null, paths: string[]): Operation[] {
  // A change of the id itself, repeated before it is saved, means the index.
  const others = paths.filter((path) => !/^\/cameras\/\d+\/id$/.test(path));
  const places = new Set(others.flatMap((path) => /^\/cameras\/\d+(?=\/|$)/.exec(path) ?? []));
  return [...places].flatMap((place) => {
    const id = valueAt(tree ?? undefined, `${place}/id`);
    return id === undefined ? [] : [{ op: 'test' as const, path: `${place}/id`, value: id }];
  });
}

async function patch(operations: Operation[], tests: Operation[], joins: boolean): Promise<Outcome> {
  const paths = operations.map(({ path }) => path);
  for (;;) {
    const moved = tests.find(({ path, value }) => !isEqual(valueAt(settings.value ?? undefined, path), value));
    const step = moved && await newestStepAt(moved.path);
    if (step) return { kind: 'stale', step };
    try {
      return takeOwn(await api.patch<SettingsRevision>(joins ? 'settings?joins=true' : 'settings', [...tests, ...operations], sameRevision()), paths, joins);
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 409) throw error;
      const { changed_since } = error.body as Stale;
      await loadSettings();
      const overtaking = changed_since.find((one) => touches(one, [...tests, ...operations]));
      if (overtaking) return { kind: 'stale', step: overtaking };
    }
  }
}

async function saveNow(operations: Operation[] | ((tree: Json) => Operation[]), tests: Operation[], joins = () => false): Promise<Outcome> {
  if (!settings.value) await loadSettings();
  if (!settings.value) throw new ApiError(0, loadError.value);
  const list = typeof operations === 'function' ? operations(settings.value) : operations;
  return list.length ? patch(list, tests.length ? tests : sameCameras(settings.value, list.map(({ path }) => path)), joins()) : { kind: 'saved' };
}

/** Saves a JSON Patch. A function is called when its turn comes, with the newest tree. */
export function save(operations: Operation[] | ((tree: Json) => Operation[])): Promise<Outcome> {
  const tests = typeof operations === 'function' ? [] : sameCameras(settings.value, operations.map(({ path }) => path));
  return inTurn(() => attempt(() => saveNow(operations, tests)));
}

const waiting = new Map<string, { value: Json; joins: boolean; outcome: Promise<Outcome> }>();

/**
 * Saves one value. While a request is pending, only the newest of the following values is sent: a slider may be
 * dragged. `joins`: the history merges it into the step of the value saved before, unless something else was changed in
 * between.
 */
export function saveValue(pointer: string, value: Json, joins = false): Promise<Outcome> {
  const before = waiting.get(pointer);
  if (before) {
    before.value = value;
    before.joins &&= joins;
    return before.outcome;
  }
  const entry = { value, joins, outcome: Promise.resolve<Outcome>({ kind: 'saved' }) };
  const tests = sameCameras(settings.value, [pointer]);
  waiting.set(pointer, entry);
  entry.outcome = inTurn(() => attempt(() => saveNow((tree) => {
    waiting.delete(pointer);
    return isEqual(valueAt(tree, pointer), entry.value) ? [] : setOperations(tree, pointer, entry.value);
  }, tests, () => entry.joins)));
  return entry.outcome;
}

/** Runs a change that the user reviewed on revision `lookedAt`; refused if the settings have changed since. */
const reviewed = (work: (headers: Record<string, string>) => Promise<SettingsRevision>, lookedAt: number, paths: string[]): Promise<Outcome> => inTurn(() => attempt(async () => {
  try {
    return takeOwn(await work({ 'If-Match': String(lookedAt) }), paths);
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 409) throw error;
    await loadSettings();
    const [newest] = (error.body as Stale).changed_since;
    return newest ? { kind: 'stale', step: newest } : { kind: 'refused', text: error.message };
  }
}));

/** Applies the parts of a profile at `paths`. */
export const applyProfile = (name: string, paths: string[], lookedAt: number): Promise<Outcome> =>
  reviewed((headers) => api.post<SettingsRevision>(`profiles/${encodeURIComponent(name)}/apply`, { paths }, headers), lookedAt, paths);

/** Applies changes selected from a file. */
export const importChanges = (operations: Operation[], lookedAt: number): Promise<Outcome> =>
  reviewed((headers) => api.patch<SettingsRevision>('settings', operations, headers), lookedAt, operations.map(({ path }) => path));

/** Replaces all stored data with a backup. */
export const restoreBackup = (file: Blob, lookedAt: number): Promise<Outcome> =>
  reviewed((headers) => api.upload<RestoredBackup>('backup/restore', file, headers), lookedAt, ['']);

/** Previews a change, or returns why it would be refused. Changes nothing. */
export async function checkChange(operations: Operation[]): Promise<{ changes: SettingsChange[] } | { error: string }> {
  try {
    return await api.post<{ changes: SettingsChange[] }>('settings/check', operations);
  } catch (error) {
    return { error: messageOf(error) };
  }
}

const forgetOwn = (step: number): void => { ownSteps.value = ownSteps.value.filter((own) => own.revision !== step); };

/** `pick` selects the step when its turn comes. */
const undo = (pick: () => number | undefined): Promise<Outcome> => inTurn(() => attempt(async () => {
  const step = pick();
  if (step === undefined) return { kind: 'saved' };
  try {
    take(await api.post<SettingsRevision>('settings/undo', { revision: step }));
    forgetOwn(step);
    return { kind: 'saved' };
  } catch (error) {
    // 422: the history does not contain it any more.
    if (error instanceof ApiError && error.status === 422) forgetOwn(step);
    if (!(error instanceof ApiError) || error.status !== 409) throw error;
    const [newest] = (error.body as Stale).changed_since;
    forgetOwn(step);
    return newest ? { kind: 'stale', step: newest } : { kind: 'refused', text: error.message };
  }
}));

/** Undoes one step of the history. */
export const undoStep = (step: number): Promise<Outcome> => undo(() => step);

/** The newest step that changed something there; null if the history has none. */
export async function newestStepAt(pointer: string): Promise<SettingsStep | null> {
  const steps = await api.get<SettingsStep[]>('settings/history').catch(() => []);
  return steps.find((step) => step.changes.some(({ path }) => overlap(path, pointer))) ?? null;
}

/** Undoes this browser's last change at or below these places, and returns its outcome and paths. */
export async function undoLast(places = ['']): Promise<{ outcome: Outcome; paths: string[] } | null> {
  if (!canUndo(places)) return null;
  let step: OwnStep | undefined;
  const outcome = await undo(() => (step = lastOwn(places))?.revision);
  return { outcome, paths: step?.paths ?? [] };
}

/** Index of a camera in the list of the settings; -1: not found. */
export function cameraIndex(id: number): number {
  const cameras = valueAt(settings.value ?? undefined, '/cameras');
  return Array.isArray(cameras) ? cameras.findIndex((camera) => valueAt(camera, '/id') === id) : -1;
}
