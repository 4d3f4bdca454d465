// SPDX-License-Identifier: Apache-2.0
// Alerts a user who is not viewing the page: by the tab's title and icon, optionally by a sound and a notification. The
// choice is stored in the browser.
import { ref, watch, watchEffect } from 'vue';
import type { Status } from '../api/types';
import { page } from '../router';
import { headline, moodOf, newTrouble, sign } from './headline';
import { isStale, knownStatus, liveStatus } from './live';

type Way = 'sound' | 'notification';
const key = (way: Way) => `away-${way}`;

function stored(way: Way): boolean {
  try {
    return localStorage.getItem(key(way)) === 'on';
  } catch {
    return false;
  }
}

export const chosen = { sound: ref(stored('sound')), notification: ref(stored('notification')) };
export const isDialogOpen = ref(false);

function choose(way: Way, on: boolean): void {
  chosen[way].value = on;
  try {
    localStorage.setItem(key(way), on ? 'on' : 'off');
  } catch {
    // Without storage the choice lasts as long as the page.
  }
}

let audio: AudioContext | null = null;
/** Browsers allow sound only after a click or a key press on the page. */
function readyAudio(): void {
  if (!chosen.sound.value) return;
  audio ??= new AudioContext();
  void audio.resume();
}

/** If the page may play sound, resuming takes at most a moment. */
const AUDIO_MS = 500;
async function canSound(): Promise<boolean> {
  readyAudio();
  await Promise.race([audio?.resume(), new Promise((resolve) => { setTimeout(resolve, AUDIO_MS); })]);
  return audio?.state === 'running';
}

/** Plays two falling tones if sound is possible now: the browser would play delayed tones together at the next click. */
export async function playSound(): Promise<void> {
  if (!await canSound()) return;
  [880, 587].forEach((hertz, i) => {
    const tone = audio!.createOscillator();
    const volume = audio!.createGain();
    const begin = audio!.currentTime + i * 0.28;
    tone.frequency.value = hertz;
    volume.gain.setValueAtTime(0.25, begin);
    volume.gain.exponentialRampToValueAtTime(0.001, begin + 0.25);
    tone.connect(volume).connect(audio!.destination);
    tone.start(begin);
    tone.stop(begin + 0.26);
  });
}

export function chooseSound(on: boolean): void {
  choose('sound', on);
  if (on) void playSound();
}

/** Why this browser shows no notifications; empty: it does, or will ask. */
export function notificationProblem(): string {
  if (!isSecureContext) return 'This browser shows notifications only over HTTPS or on the service’s own computer.';
  if (!('Notification' in window)) return 'This browser has no notifications.';
  return Notification.permission === 'denied' ? 'This browser blocks notifications from this page. Allow them in its settings for this page.' : '';
}

async function notify(text: string): Promise<void> {
  // One tag per problem, with renotify: otherwise a browser replaces a notification with the same tag silently.
  const options = { body: text, tag: `ssl-visiond ${text}`, renotify: true, icon: 'icon-192.png' };
  const title = knownStatus.value?.site || 'ssl-visiond';
  try {
    const registration = await navigator.serviceWorker?.getRegistration();
    // The only way on some phones.
    if (registration?.active) return await registration.showNotification(title, options);
    const shown = new Notification(title, options);
    shown.onclick = () => { focus(); shown.close(); };
  } catch {
    // The title and the icon still show it.
  }
}

/** Returns why it could not be turned on; empty on success. */
export async function chooseNotification(on: boolean): Promise<string> {
  if (on && !notificationProblem() && Notification.permission === 'default') await Notification.requestPermission();
  const problem = on ? notificationProblem() || (Notification.permission === 'granted' ? '' : 'Not allowed yet: answer the browser’s question first.') : '';
  choose('notification', on && !problem);
  return problem;
}

/** Silence of the service that triggers an alert. */
const SILENCE_MS = 10_000;

const isLookedAt = () => document.visibilityState === 'visible' && document.hasFocus();

function showSign(href: string): void {
  const link = document.querySelector<HTMLLinkElement>('link[rel="icon"]');
  if (link && link.href !== href) link.href = href;
}

export function tellAway(): void {
  watchEffect(() => {
    document.title = headline(liveStatus.value, isStale.value, page.value.title, knownStatus.value?.site || 'ssl-visiond');
    showSign(sign(moodOf(liveStatus.value)));
  });
  const tell = (trouble: string) => {
    if (isLookedAt()) return;
    if (chosen.sound.value) void playSound();
    if (chosen.notification.value) void notify(trouble);
  };
  let before: Status | null = null;
  watch(liveStatus, (now) => {
    if (!now) return;
    const trouble = before && newTrouble(before, now);
    before = now;
    if (trouble) tell(trouble);
  });
  // Alerts once per silence. A restarted service answers sooner.
  let silence: ReturnType<typeof setTimeout> | undefined;
  watch(isStale, (stale) => {
    clearTimeout(silence);
    if (stale && before) silence = setTimeout(() => tell('No data from the service'), SILENCE_MS);
  });
  for (const kind of ['pointerdown', 'keydown']) addEventListener(kind, readyAudio, { once: true, capture: true });
}
