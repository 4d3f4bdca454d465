// SPDX-License-Identifier: Apache-2.0
// What this visitor may do, and the questions that a change requires: a password, or confirmation during a match.
import { computed, ref, shallowRef, watch } from 'vue';
import { api, onClosedDoor } from '../api/client';
import type { Session } from '../api/types';
import { connection, liveStatus } from './live';

/** null until the service has answered. */
export const access = shallowRef<Session | null>(null);
export const mayChange = computed(() => access.value?.may === 'change');
export const isLocked = computed(() => access.value?.match_lock.locked ?? false);
export const isUnlocked = computed(() => access.value?.match_lock.opened ?? false);
/** For locked controls: why, and what to do. */
export const LOCK_REASON = 'The game controller says that a match is running, so settings are locked. Wait for HALT, or unlock them at the top of the page.';
let loadedAt = 0;
const LOCK_MS = 2000;

export async function loadAccess(): Promise<void> {
  try {
    loadedAt = performance.now();
    access.value = await api.get<Session>('session');
  } catch {
    // The connection indicator shows that there is no answer.
  }
}

/** The dialog's question: a password for a change, confirmation of a change during a match, or new passwords. */
export type Question = 'sign-in' | 'match' | 'passwords';
export const question = ref<Question | null>(null);

let answerQuestion: ((goOn: boolean) => void) | null = null;
let asked: Promise<boolean> | null = null;

function askAbout(about: Question): Promise<boolean> {
  // Several changes may wait for the same answer.
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

/** Asks whether to unlock the settings for this match; nothing else depends on the answer. */
export function askToUnlock(): void { void askAbout('match'); }

/** For the top bar's button. */
export const openAccess = () => { if (!question.value) question.value = access.value?.may === 'change' ? 'passwords' : 'sign-in'; };

/** The question was answered or dismissed. */
export function closeQuestion(goOn: boolean): void {
  if (answerQuestion) answerQuestion(goOn);
  else question.value = null;
}

/** Each throws ApiError. */
export async function signIn(password: string): Promise<void> {
  const mayLookNow = access.value?.may !== 'nothing';
  access.value = await api.post<Session>('session', { password });
  // Reloads, to repeat the requests that were refused so far.
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
    // The user may have signed in meanwhile, in another tab.
    if (status === 401) return mayChange.value || (await askAbout('sign-in') && mayChange.value);
    return isLocked.value && await askAbout('match');
  });
  void loadAccess();
  // The service may have restarted, or a match may have begun or ended.
  watch([connection, () => liveStatus.value?.referee.game_is_running], () => { void loadAccess(); });
  // Polled during a match: another admin may unlock it, and the lock ends when the game controller has been silent for
  // long.
  watch(liveStatus, (status) => {
    const isMatch = status?.referee.game_is_running || access.value?.match_lock.game_is_running || isUnlocked.value;
    if (isMatch && performance.now() - loadedAt > LOCK_MS) void loadAccess();
  });
}
