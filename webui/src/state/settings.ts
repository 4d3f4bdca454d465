// SPDX-License-Identifier: Apache-2.0
// The settings tree as the service has it, and changes on their way to it. A change counts once the service says that
// it is on disk; one that was made on an older revision is only sent again when nobody else touched the same.
import { computed, ref, shallowRef, watch } from 'vue';
import { api, ApiError, messageOf } from '../api/client';
import type { RestoredBackup, SettingsChange, SettingsRevision, SettingsStep, Stale } from '../api/types';
import { overlap, setOperations, valueAt, type Json, type Operation } from '../settings/pointer';
import type { SchemaNode } from '../settings/schema';
import { knownStatus } from './live';

/** null until loaded. */
export const settings = shallowRef<Json | null>(null);
export const revision = ref(0);
/** Version of the settings' format, which an export says. */
export const version = ref(1);
export const schema = shallowRef<SchemaNode | null>(null);
/** Why they could not be loaded. */
export const loadError = ref('');

export type SaveState =
  | { kind: 'idle' }
  | { kind: 'saving' }
  | { kind: 'saved'; at: Date }
  | { kind: 'failed'; text: string };
export const saveState = ref<SaveState>({ kind: 'idle' });

export type Outcome =
  | { kind: 'saved' }
  /** Not allowed; `text` says why. The old settings stay. */
  | { kind: 'refused'; text: string }
  /** Somebody else changed the same meanwhile: the newest such step. */
  | { kind: 'stale'; step: SettingsStep }
  /** The service could not be asked, or could not save. */
  | { kind: 'failed'; text: string };

function take(answer: SettingsRevision): void {
  if (answer.revision < revision.value) return;
  settings.value = answer.settings as Json;
  version.value = answer.version;
  revision.value = answer.revision;
}

let loading: Promise<void> | null = null;

/** Loads settings and schema; those who come while that lasts wait for the same. */
export function loadSettings(): Promise<void> {
  loading ??= (async () => {
    const before = revision.value;
    try {
      const [answer, newSchema] = await Promise.all([
        api.get<SettingsRevision>('settings'),
        schema.value ?? api.get<SchemaNode>('schema'),
      ]);
      schema.value = newSchema;
      // A restarted service may count from an older revision; but an answer that a newer one has overtaken is old.
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

/** For components: the tree, loaded now unless it is, and kept up with what others change. */
export function useSettings() {
  if (!settings.value) void loadSettings();
  return { settings, schema, revision, loadError };
}
watch(knownStatus, (status, before) => {
  const newest = status?.settings_revision;
  if (!settings.value || newest === undefined || newest === revision.value || saveState.value.kind === 'saving') return;
  // With every status: what was loaded or saved last may have been answered before the newest step. A status that is
  // behind is late; one that goes back is of a restarted service.
  if (newest > revision.value || newest !== before?.settings_revision) void loadSettings();
});

/** Steps that this browser made and that can be taken back, newest last. */
const ownSteps = ref<number[]>([]);
export const canUndo = computed(() => ownSteps.value.length > 0);

/** Changes go one after the other, so that each is made on what the one before left. */
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

/** Shows, where changes of settings are shown, what becomes of a request that saves in another way. Throws what it throws. */
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

function takeOwn(answer: SettingsRevision): Outcome {
  if (answer.revision !== revision.value) ownSteps.value.push(answer.revision);
  take(answer);
  return { kind: 'saved' };
}

async function patch(operations: Operation[]): Promise<Outcome> {
  for (;;) {
    try {
      return takeOwn(await api.patch<SettingsRevision>('settings', operations, sameRevision()));
    } catch (error) {
      if (!(error instanceof ApiError) || error.status !== 409) throw error;
      const { changed_since } = error.body as Stale;
      await loadSettings();
      const step = changed_since.find((one) => touches(one, operations));
      if (step) return { kind: 'stale', step };
    }
  }
}

/** Saves a JSON Patch. `operations` is asked for when its turn comes, on the newest tree. */
export const save = (operations: Operation[] | ((tree: Json) => Operation[])): Promise<Outcome> => inTurn(() => attempt(async () => {
  if (!settings.value) await loadSettings();
  if (!settings.value) throw new ApiError(0, loadError.value);
  const list = typeof operations === 'function' ? operations(settings.value) : operations;
  return list.length ? patch(list) : { kind: 'saved' };
}));

const waiting = new Map<string, { value: Json; outcome: Promise<Outcome> }>();

/** Saves one value. While one is on its way, only the newest of those that follow is sent: a slider may be dragged. */
export function saveValue(pointer: string, value: Json): Promise<Outcome> {
  const before = waiting.get(pointer);
  if (before) {
    before.value = value;
    return before.outcome;
  }
  const entry = { value, outcome: Promise.resolve<Outcome>({ kind: 'saved' }) };
  waiting.set(pointer, entry);
  entry.outcome = save((tree) => {
    waiting.delete(pointer);
    return setOperations(tree, pointer, entry.value);
  });
  return entry.outcome;
}

/** Applies the parts of a profile that lie at `paths`. */
export const applyProfile = (name: string, paths: string[]): Promise<Outcome> => inTurn(() => attempt(async () => {
  try {
    return takeOwn(await api.post<SettingsRevision>(`profiles/${encodeURIComponent(name)}/apply`, { paths }, sameRevision()));
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 409) throw error;
    await loadSettings();
    const [newest] = (error.body as Stale).changed_since;
    return newest ? { kind: 'stale', step: newest } : { kind: 'refused', text: error.message };
  }
}));

/** Takes a backup for everything that is kept, if the settings are still at the revision it was compared with. */
export const restoreBackup = (file: Blob, comparedWith: number): Promise<Outcome> => inTurn(() => attempt(async () => {
  try {
    return takeOwn(await api.upload<RestoredBackup>('backup/restore', file, { 'If-Match': String(comparedWith) }));
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 409) throw error;
    await loadSettings();
    const [newest] = (error.body as Stale).changed_since;
    return newest ? { kind: 'stale', step: newest } : { kind: 'refused', text: error.message };
  }
}));

/** What a change would do, or why it would be refused. Nothing is changed. */
export async function checkChange(operations: Operation[]): Promise<{ changes: SettingsChange[] } | { error: string }> {
  try {
    return await api.post<{ changes: SettingsChange[] }>('settings/check', operations);
  } catch (error) {
    return { error: messageOf(error) };
  }
}

/** `pick` is asked for the step when its turn comes. */
const undo = (pick: () => number | undefined): Promise<Outcome> => inTurn(() => attempt(async () => {
  const step = pick();
  if (step === undefined) return { kind: 'saved' };
  try {
    take(await api.post<SettingsRevision>('settings/undo', { revision: step }));
    ownSteps.value = ownSteps.value.filter((own) => own !== step);
    return { kind: 'saved' };
  } catch (error) {
    if (!(error instanceof ApiError) || error.status !== 409) throw error;
    const [newest] = (error.body as Stale).changed_since;
    ownSteps.value = ownSteps.value.filter((own) => own !== step);
    return newest ? { kind: 'stale', step: newest } : { kind: 'refused', text: error.message };
  }
}));

/** Takes one step of the history back. */
export const undoStep = (step: number): Promise<Outcome> => undo(() => step);

/** The newest step that changed something there; null when the history knows none. */
export async function newestStepAt(pointer: string): Promise<SettingsStep | null> {
  const steps = await api.get<SettingsStep[]>('settings/history').catch(() => []);
  return steps.find((step) => step.changes.some(({ path }) => overlap(path, pointer))) ?? null;
}

/** Takes this browser's last change back. */
export const undoLast = (): Promise<Outcome> | null => (canUndo.value ? undo(() => ownSteps.value.at(-1)) : null);

/** The place of a camera in the list of the settings; -1 when it is not there. */
export function cameraIndex(id: number): number {
  const cameras = valueAt(settings.value ?? undefined, '/cameras');
  return Array.isArray(cameras) ? cameras.findIndex((camera) => valueAt(camera, '/id') === id) : -1;
}
