// SPDX-License-Identifier: Apache-2.0
// Texts about recording.
import type { MatchLog, MatchLogNow, Recordings, Status } from '../../api/types';
import { bytes } from '../../bytes';
import { duration, figure, plural, timeOfDay } from '../../format';
import type { IconName } from '../../components/icons';
import { QUIET_S } from '../../state/match';
import { dayAndTime, readName } from './names';

export interface Now {
  level: '' | 'ok' | 'warn' | 'bad' | 'info';
  icon: IconName;
  /** One word. */
  word: string;
  /** One sentence. */
  text: string;
  /** Further details or advice; empty: none. */
  more: string;
}

/** Whether the log is open and can be stopped. */
export const isWriting = ({ state }: MatchLogNow): boolean => state === 'recording' || state === 'paused';
/** Whether that log is being written. */
export const isWritten = (now: MatchLogNow, name: string): boolean => isWriting(now) && now.name === name;

const titleOf = ({ name }: MatchLogNow) => (name === null ? 'Match log' : readName(name).title);
const size = (now: MatchLogNow) => `${duration(now.seconds)}, ${bytes(now.bytes)}`;

/** With less free space, a full disk is the cause. */
const FULL_BYTES = 100e6;

export function nowText({ match_log: now, disk }: Pick<Recordings, 'match_log' | 'disk'>): Now {
  switch (now.state) {
    case 'recording': {
      const since = now.begin_s === null ? '' : ` since ${timeOfDay(now.begin_s, false)}`;
      return { level: 'ok', icon: 'record', word: 'Recording', text: `Recording${since}: ${titleOf(now)}, ${size(now)}`, more: startedText(now) };
    }
    case 'paused':
      return { level: 'info', icon: 'pause', word: 'Paused', text: `Paused: break. ${titleOf(now)}, ${size(now)} so far`, more: 'The log continues when the match does.' };
    case 'waiting':
      if (now.error) return { level: 'warn', icon: 'warn', word: 'Cannot record', text: `No match can be recorded: ${now.error}`, more: 'Download and delete recordings, or give them more disk space (Settings, recording).' };
      return { level: 'info', icon: 'history', word: 'Waiting', text: 'Waiting for the game controller: recording starts when both teams are named and HALT ends', more: 'Or start it now by hand.' };
    case 'left_out':
      return { level: 'warn', icon: 'warn', word: 'Not recorded', text: `This match is not recorded: ${now.error || 'its log was stopped'}`, more: 'Press Record to record the rest of it. The next match is recorded again.' };
    case 'off':
      return { level: '', icon: 'minus', word: 'Off', text: 'Off', more: 'Nothing is recorded until you press Record.' };
    case 'failed':
      return {
        level: 'bad', icon: 'cross', word: 'Failed', text: `Nothing is recorded: ${now.error || 'the log cannot be written'}`,
        more: disk.free_bytes < FULL_BYTES ? 'The disk is full. Delete logs or other files, then press Record.' : 'Check the disk and the folder of the recordings, then press Record.',
      };
  }
}

function startedText({ started_by }: MatchLogNow): string {
  if (started_by === 'game_controller') return 'Started by the game controller. It ends when the match is over.';
  return started_by === 'hand' ? 'Started by hand. It records until you press Stop.' : '';
}

/** Missing vision messages are reported only in a log that is at least this old. */
const FIRST_MESSAGES_S = 5;

export interface Hint {
  id: 'lost' | 'vision' | 'controller';
  text: string;
  /** Where to check, as a page of the router. */
  place: { text: string; page: string; argument: string };
}

/** Problems with what is recorded, or why recording does not start. `referee`: null while unknown. */
export function hintsOf(now: MatchLogNow, referee: Pick<Status['referee'], 'enabled' | 'silent_s'> | null): Hint[] {
  const hints: Hint[] = [];
  if (now.lost > 0) {
    const [were, are] = now.lost === 1 ? ['was', 'is'] : ['were', 'are'];
    hints.push({
      id: 'lost', text: `${plural(now.lost, 'message')} ${were} lost and ${are} not in the log: the disk is too slow. Use a faster disk, or stop other programs that write to it.`,
      place: { text: 'Open Diagnostics', page: 'diagnostics', argument: '' },
    });
  }
  if (now.state === 'recording' && now.seconds >= FIRST_MESSAGES_S && now.messages.vision === 0) {
    hints.push({
      id: 'vision', text: 'No vision message has been received: the log has no robots and no ball. Check that cameras run and that packets are sent.',
      place: { text: 'Open the packets', page: 'field', argument: 'packets' },
    });
  }
  if (now.state === 'waiting' && referee !== null && (!referee.enabled || (referee.silent_s ?? Infinity) > QUIET_S)) {
    hints.push({
      id: 'controller',
      text: referee.enabled ? 'No game controller message is received, so nothing starts automatically.' : 'Listening to the game controller is off in the settings, so nothing starts automatically.',
      place: { text: 'Open the network', page: 'field', argument: 'network' },
    });
  }
  return hints;
}

/** "12 GB of 50 GB"; a quota of 0 means none. */
export const usedText = ({ used_bytes, quota_bytes }: Recordings['disk']): string => (quota_bytes > 0 ? `${bytes(used_bytes)} of ${bytes(quota_bytes)}` : bytes(used_bytes));

export type Kept = Pick<MatchLog, 'bytes' | 'pinned'>;

/** Shares of the bar, 0 to 1: pinned logs, and the others. */
export function sharesOf({ used_bytes, quota_bytes }: Recordings['disk'], kept: readonly Kept[]): { pinned: number; others: number } {
  const whole = Math.max(quota_bytes, used_bytes, 1);
  const pinned = Math.min(pinnedBytes(kept), used_bytes);
  return { pinned: pinned / whole, others: (used_bytes - pinned) / whole };
}
export const pinnedBytes = (kept: readonly Kept[]): number => kept.reduce((sum, one) => sum + (one.pinned ? one.bytes : 0), 0);

export interface LogFacts {
  title: string;
  phase: string;
  when: string;
  /** Empty if unknown. */
  length: string;
  size: string;
  goals: string;
  messages: string;
  /** The service is still reading the file. */
  isReading: boolean;
}

export function factsOf(log: MatchLog): LogFacts {
  const { title, phase, when } = readName(log.name);
  const { messages } = log;
  return {
    title, phase,
    when: log.begin_s === null ? when : dayAndTime(log.begin_s),
    length: log.seconds === null ? '' : duration(log.seconds),
    size: bytes(log.bytes),
    goals: log.goals === null ? '' : plural(log.goals, 'goal'),
    messages: messages ? `${figure(messages.vision)} vision, ${figure(messages.referee)} referee, ${figure(messages.tracked)} tracked messages` : '',
    isReading: !log.problem && (log.seconds === null || messages === null),
  };
}
