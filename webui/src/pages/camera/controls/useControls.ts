// SPDX-License-Identifier: Apache-2.0
// A camera's own controls: current values, unsaved changes, and pending requests.
import { computed, onUnmounted, ref, shallowRef, watch } from 'vue';
import { api, ApiError, messageOf } from '../../../api/client';
import type { CameraStatus, Control } from '../../../api/types';
import { newestOnly } from '../../../api/newestOnly';
import { setOperations, pointerOf, valueAt, type Json } from '../../../settings/pointer';
import { cameraIndex, save, settings, useSettings } from '../../../state/settings';
import { isSame, type Value } from './controls';

/** One control may change the values or limits of others, so all are requested again after this long without a change. */
const ASK_AGAIN_MS = 400;

export function useControls(camera: () => CameraStatus) {
  useSettings();
  const list = shallowRef<readonly Control[] | null>(null);
  /** Why the list is missing. */
  const listError = ref('');
  const errors = ref<Record<string, string>>({});
  /** Shown until the camera has answered. */
  const drafts = ref<Record<string, Value>>({});
  /** Values that can only be saved, because the camera is reopened for them. */
  const toSave = ref<Record<string, Value>>({});
  /** A value was set and the camera accepted it. */
  const isApplied = ref(false);

  const folder = computed(() => pointerOf(['cameras', cameraIndex(camera().id), 'source', 'controls']));
  const savedValues = computed(() => valueAt(settings.value ?? undefined, folder.value) ?? {});

  let alive = true;
  let timer: ReturnType<typeof setTimeout> | undefined;
  async function load(): Promise<void> {
    clearTimeout(timer);
    if (camera().state !== 'running' && camera().state !== 'ended') return;
    const { id } = camera();
    try {
      const answer = await api.get<{ controls: Control[] }>(`cameras/${id}/controls`);
      if (!alive || id !== camera().id) return;
      list.value = answer.controls;
      listError.value = '';
    } catch (error) {
      listError.value = messageOf(error);
    }
  }
  const loadSoon = () => {
    clearTimeout(timer);
    timer = setTimeout(load, ASK_AGAIN_MS);
  };
  onUnmounted(() => {
    alive = false;
    clearTimeout(timer);
  });
  // A reopened camera may have other values; so may one that another user changed.
  watch(() => camera().state, load, { immediate: true });
  watch(() => [camera().controls_unsaved, camera().reconnects].join(), loadSoon);
  watch(savedValues, (now, then) => { if (JSON.stringify(now) !== JSON.stringify(then)) loadSoon(); });

  const line = newestOnly<Value>(async (name, value) => {
    try {
      const answer = await api.post<Control>(`cameras/${camera().id}/controls/${encodeURIComponent(name)}`, value === null ? undefined : { value });
      list.value = list.value?.map((control) => (control.name === name ? answer : control)) ?? null;
      delete errors.value[name];
      delete toSave.value[name];
      isApplied.value = true;
    } catch (error) {
      const isReopened = error instanceof ApiError && error.status === 409 && camera().state === 'running';
      if (isReopened) toSave.value[name] = value;
      if (isReopened) delete errors.value[name];
      else errors.value[name] = messageOf(error);
    }
    if (!line.isWaiting(name)) delete drafts.value[name];
  }, loadSoon);

  function set(name: string, value: Value): void {
    const control = list.value?.find((one) => one.name === name);
    if (!control) return;
    if (control.kind !== 'action') drafts.value[name] = value;
    line.put(name, value);
  }

  const valueOf = (control: Control): Value => drafts.value[control.name] ?? toSave.value[control.name] ?? control.value;
  /** The value that "Revert" restores. */
  const homeOf = (control: Control): Value => (control.unsaved ? control.revert_to : control.value);
  const isChanged = (control: Control): boolean => {
    if (!control.writable || control.kind === 'action') return false;
    const value = valueOf(control);
    if (control.unsaved && value === control.value) return true;
    const isSaved = control.saved_value !== null && isSame(control, value, control.saved_value);
    return !isSaved && !isSame(control, value, homeOf(control));
  };
  const changed = computed(() => list.value?.filter(isChanged) ?? []);
  /** A save or revert is pending. */
  const isBusy = ref(false);
  const isSetting = computed(() => isBusy.value || Object.keys(drafts.value).length > 0);

  /** Why saving or reverting failed. */
  const problem = ref('');
  async function saveOnly(controls: readonly Control[]): Promise<void> {
    const values = Object.fromEntries(controls.map((control) => [control.name, valueOf(control) as Json]));
    isBusy.value = true;
    const outcome = await save((tree) => {
      const all = { ...(valueAt(tree, folder.value) as Record<string, Json> | undefined), ...values };
      return setOperations(tree, folder.value, all);
    });
    problem.value = outcome.kind === 'refused' || outcome.kind === 'failed' ? outcome.text
      : outcome.kind === 'saved' ? outcome.refused?.map((line) => `Saved, but rejected by the camera: ${line}`).join('; ') ?? ''
      : outcome.kind === 'stale' ? `${outcome.step.who} has changed the camera's controls. Check them and save again.` : '';
    if (outcome.kind === 'saved') forget(Object.keys(values));
    await load();
    isBusy.value = false;
  }
  async function revert(names?: string[]): Promise<void> {
    problem.value = '';
    isBusy.value = true;
    try {
      list.value = (await api.post<{ controls: Control[] }>(`cameras/${camera().id}/revert_controls`, names ? { names } : {})).controls;
    } catch (error) {
      problem.value = messageOf(error);
      await load();
    }
    isBusy.value = false;
  }
  function forget(names: readonly string[]): void {
    for (const name of names) {
      delete toSave.value[name];
      delete errors.value[name];
    }
  }

  return {
    list, listError, errors, isApplied, set, valueOf, homeOf, isChanged, changed, isSetting, problem,
    isReopened: ({ name }: Control) => name in toSave.value,
    saveOne: (control: Control) => saveOnly([control]),
    saveAll: () => saveOnly(changed.value),
    async revertOne(control: Control): Promise<void> {
      forget([control.name]);
      if (control.unsaved) await revert([control.name]);
    },
    async revertAll(): Promise<void> {
      forget(changed.value.map(({ name }) => name));
      await revert();
    },
    /** The input is not a valid value. */
    refuse(name: string, text: string) { errors.value[name] = text; },
  };
}
