// SPDX-License-Identifier: Apache-2.0
// What this visitor may do, and the questions that stand in the way of a change: a password, a running match.
import { computed, ref, shallowRef, watch } from 'vue';
import { api, onClosedDoor } from '../api/client';
import type { Session } from '../api/types';
import { connection, liveStatus } from './live';

/** null until the service has said so. */
export const access = shallowRef<Session | null>(null);
export const mayChange = computed(() => access.value?.may === 'change');
export const isLocked = computed(() => access.value?.match_lock.locked ?? false);
export const isUnlocked = computed(() => access.value?.match_lock.opened ?? false);
/** For controls that are locked: why, and what to do. */
export const LOCK_REASON = 'The game controller says that a match is running, so settings are locked. Wait for HALT, or unlock them at the top of the page.';
let loadedAt = 0;
const LOCK_MS = 2000;

export async function loadAccess(): Promise<void> {
  try {
    loadedAt = performance.now();
    access.value = await api.get<Session>('session');
  } catch {
    // The connection's mark says that nobody answers.
  }
}

/** What the dialog asks: nothing, a password for a change, or leave to change something in a match. */
export type Question = 'sign-in' | 'match' | 'passwords';
export const question = ref<Question | null>(null);

let answerQuestion: ((goOn: boolean) => void) | null = null;
let asked: Promise<boolean> | null = null;

function askAbout(about: Question): Promise<boolean> {
  // Several changes may stand at the same door.
  asked ??= new Promise<boolean>((resolve) => {
    question.value = about;
    answerQuestion = resolve;
  }).finally(() => {
    asked = null;
    question.value = null;
    answerQuestion = null;
  });
  return asked;
}

/** Asks whether to unlock the settings for this match; nothing else waits for the answer. */
export function askToUnlock(): void { void askAbout('match'); }

/** For the top bar's button. */
export const openAccess = () => { if (!question.value) question.value = access.value?.may === 'change' ? 'passwords' : 'sign-in'; };

/** The question is answered, or put away. */
export function closeQuestion(goOn: boolean): void {
  if (answerQuestion) answerQuestion(goOn);
  else question.value = null;
}

/** Each throws ApiError. */
export async function signIn(password: string): Promise<void> {
  const mayLookNow = access.value?.may !== 'nothing';
  access.value = await api.post<Session>('session', { password });
  // All that was refused so far is asked for again.
  if (!mayLookNow) location.reload();
}

export async function signOut(): Promise<void> {
  access.value = await api.delete<Session>('session');
  if (access.value.may === 'nothing') location.reload();
}

export async function setPassword(role: 'admin' | 'viewer', password: string, adminPassword: string): Promise<void> {
  access.value = await api.putWithPassword<Session>(`passwords/${role}`, { password, admin_password: adminPassword });
}

export async function openMatchLock(opened: boolean): Promise<void> {
  try {
    await api.post('match_lock', { opened });
  } finally {
    await loadAccess();
  }
}

export function followAccess(): void {
  onClosedDoor(async (status) => {
    await loadAccess();
    // Somebody may have signed in meanwhile, in another tab.
    if (status === 401) return mayChange.value || (await askAbout('sign-in') && mayChange.value);
    return isLocked.value && await askAbout('match');
  });
  void loadAccess();
  // The service may have been started again, or a match may have begun or ended.
  watch([connection, () => liveStatus.value?.referee.game_is_running], () => { void loadAccess(); });
  // Another admin may unlock, and a game controller that is silent for long locks nobody out until it is heard again: as
  // long as there is a match, ask.
  watch(liveStatus, (status) => {
    const isMatch = status?.referee.game_is_running || access.value?.match_lock.game_is_running || isUnlocked.value;
    if (isMatch && performance.now() - loadedAt > LOCK_MS) void loadAccess();
  });
}
