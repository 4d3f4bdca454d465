// SPDX-License-Identifier: Apache-2.0
// A camera's own controls: as they are now, as they are saved, and what is on its way to the camera.
import { computed, onUnmounted, ref, shallowRef, watch } from 'vue';
import { api, messageOf } from '../../../api/client';
import type { CameraStatus, Control } from '../../../api/types';
import { setOperations, pointerOf, valueAt, type Json } from '../../../settings/pointer';
import { cameraIndex, save, settings, useSettings } from '../../../state/settings';
import { isSame, type Value } from './controls';
import { newestOnly } from '../../../api/newestOnly';

/** One control may change what others are or allow. They are asked for once nothing was changed for so long. */
const ASK_AGAIN_MS = 400;

export function useControls(camera: () => CameraStatus) {
  useSettings();
  const list = shallowRef<readonly Control[] | null>(null);
  /** Why there is no list. */
  const listError = ref('');
  const errors = ref<Record<string, string>>({});
  /** Shown until the camera has answered. */
  const drafts = ref<Record<string, Value>>({});
  /** What the camera had before it was changed here; of what is saved, the saved value is what counts. */
  const before = ref<Record<string, Value>>({});
  /** Something was set and the camera took it. */
  const isApplied = ref(false);

  const folder = computed(() => pointerOf(['cameras', cameraIndex(camera().id), 'source', 'controls']));
  const savedValues = computed(() => (valueAt(settings.value ?? undefined, folder.value) ?? {}) as Record<string, Value>);

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
  // A camera that comes back may have other values; so may one whose settings somebody else changed.
  watch(() => camera().state, load, { immediate: true });
  watch(savedValues, (now, then) => { if (JSON.stringify(now) !== JSON.stringify(then)) loadSoon(); });

  const line = newestOnly<Value>(async (name, value) => {
    try {
      const answer = await api.post<Control>(`cameras/${camera().id}/controls/${encodeURIComponent(name)}`, value === null ? undefined : { value });
      list.value = list.value?.map((control) => (control.name === name ? answer : control)) ?? null;
      delete errors.value[name];
      isApplied.value = true;
    } catch (error) {
      errors.value[name] = messageOf(error);
    }
    if (!line.isWaiting(name)) delete drafts.value[name];
  }, loadSoon);

  function set(name: string, value: Value): void {
    const control = list.value?.find((one) => one.name === name);
    if (!control) return;
    if (control.kind !== 'action') {
      if (!(name in before.value)) before.value[name] = control.value;
      drafts.value[name] = value;
    }
    line.put(name, value);
  }

  const valueOf = (control: Control): Value => drafts.value[control.name] ?? control.value;
  /** What "Back" goes back to; undefined where nothing is known to go back to. */
  const homeOf = ({ name }: Control): Value | undefined => (name in savedValues.value ? savedValues.value[name] : before.value[name]);
  const isSaved = ({ name }: Control) => name in savedValues.value;
  const isChanged = (control: Control): boolean => {
    const home = homeOf(control);
    return control.writable && control.kind !== 'action' && home !== undefined && !isSame(control, valueOf(control), home);
  };
  const changed = computed(() => list.value?.filter(isChanged) ?? []);

  const saveError = ref('');
  const isSaving = ref(false);
  async function saveAll(): Promise<void> {
    const values = Object.fromEntries(changed.value.map((control) => [control.name, valueOf(control) as Json]));
    isSaving.value = true;
    const outcome = await save((tree) => {
      const all = { ...(valueAt(tree, folder.value) as Record<string, Json> | undefined), ...values };
      return setOperations(tree, folder.value, all);
    });
    isSaving.value = false;
    saveError.value = outcome.kind === 'refused' || outcome.kind === 'failed' ? outcome.text
      : outcome.kind === 'stale' ? `${outcome.step.who} has changed the camera's controls; check them and save again` : '';
    await load();
  }
  const goBack = (control: Control) => {
    const home = homeOf(control);
    if (home !== undefined) set(control.name, home);
  };

  return {
    list, listError, errors, isApplied, set, valueOf, homeOf, isSaved, isChanged, changed,
    saveAll, isSaving, saveError, goBack,
    goAllBack: () => changed.value.forEach(goBack),
    /** What was typed and is no value. */
    refuse(name: string, text: string) { errors.value[name] = text; },
  };
}
