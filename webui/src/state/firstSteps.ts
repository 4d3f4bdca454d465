// SPDX-License-Identifier: Apache-2.0
// The steps from a fresh install to GO, done or missing according to the service's own checks and alerts.
import type { Alert, CameraStatus, Check, Session, Status } from '../api/types';
import { plural } from '../format';

export interface Step {
  id: 'camera' | 'network' | 'field' | 'colours' | 'calibration' | 'robots' | 'password';
  title: string;
  /** todo: still to do; trouble: it was done, but something is wrong now. */
  state: 'done' | 'todo' | 'trouble';
  /** What is done, or what is missing. */
  text: string;
  action: { text: string; href: string } | { text: string; does: 'password' | 'address' };
  /** Once done it stays done, whatever is on the field and whether or not cameras answer. */
  lasts: boolean;
}

/** Like the router's, which needs a window. */
const link = (page: string, argument?: string | number) => (argument === undefined ? `#/${page}` : `#/${page}/${argument}`);
const isThisComputer = (card: string) => card === 'lo' || card.startsWith('127.');
const SIMULATED_ONLY = 'Tested only with simulated or recorded images';

function camera(real: CameraStatus[], all: CameraStatus[]): Step {
  const action = { text: real.length ? 'Cameras' : 'Add a camera', href: link('settings', 'cameras') };
  const base = { id: 'camera' as const, title: 'A camera', action, lasts: true };
  if (!all.length) return { ...base, state: 'todo', text: 'There is no camera yet' };
  if (!real.length) return { ...base, state: 'todo', text: `A real camera is missing: ${all.every(({ origin }) => origin === 'simulation') ? 'simulated' : 'simulated or recorded'} images only` };
  const running = real.filter(({ state }) => state === 'running').length;
  return running ? { ...base, state: 'done', text: `${running} of ${plural(real.length, 'camera')} ${running === 1 ? 'runs' : 'run'}` }
    : { ...base, state: 'trouble', text: real[0]!.error || 'No camera runs' };
}

function network(status: Status, alerts: Alert[]): Step {
  const card = status.network.interface;
  const base = { id: 'network' as const, title: 'The teams’ network', action: { text: 'Choose the card', href: link('field', 'network') }, lasts: true };
  if (isThisComputer(card)) return { ...base, state: 'todo', text: 'Packets stay on this computer: no team receives them' };
  const alert = alerts.find(({ id }) => ['not_sending', 'only_this_computer', 'card_no_link', 'card_wrong', 'card_not_chosen'].includes(id));
  if (alert) return { ...base, state: 'trouble', text: alert.title };
  return { ...base, state: 'done', text: `Packets go out on ${card || 'the card that the system chooses'}` };
}

function field(status: Status, checks: Map<string, Check>, alerts: Alert[], onlyTried: boolean): Step {
  const { field_length, field_width } = status.field;
  const size = `${field_length / 1000} x ${field_width / 1000} m`;
  const base = { id: 'field' as const, title: 'The field’s size', action: { text: 'Set the size', href: link('field') }, lasts: false };
  const alert = alerts.find(({ id }) => id === 'field_size' || id === 'lines_missing');
  if (alert) return { ...base, state: 'trouble', text: alert.title };
  const agreement = checks.get('agreement');
  const isMeasured = agreement !== undefined && agreement.state === 'pass' && /\d/.test(agreement.value);
  if (isMeasured && !onlyTried) return { ...base, state: 'done', text: `${size}, as the painted lines show` };
  return { ...base, state: 'todo', text: `${size}: compare it with your field. Calibrated cameras then measure the lines` };
}

/** A step that is required for every camera: `missing` and `wrong` are kinds of alerts. */
function ofCameras(base: Pick<Step, 'id' | 'title'>, page: 'colours' | 'calibration', verb: string, done: string, cameras: CameraStatus[], alerts: Alert[],
  onlyTried: boolean, missing: string[], wrong: string[]): Step {
  const about = (kinds: string[]) => alerts.filter(({ id, camera: of }) => kinds.includes(id) && cameras.some((one) => one.id === of));
  const [todo] = about(missing);
  const [trouble] = about(wrong);
  const first = todo?.camera ?? trouble?.camera ?? cameras[0]?.id;
  const whole = { ...base, action: { text: verb, href: first === undefined ? link(page) : link(page, first) }, lasts: true };
  if (!cameras.length) return { ...whole, state: 'todo', text: 'Add a camera first' };
  if (todo) return { ...whole, state: 'todo', text: todo.title };
  if (onlyTried) return { ...whole, state: 'todo', text: SIMULATED_ONLY };
  if (trouble) return { ...whole, state: 'trouble', text: trouble.title };
  return { ...whole, state: 'done', text: done };
}

function robots(cameras: CameraStatus[], checks: Map<string, Check>, onlyTried: boolean): Step {
  const base = { id: 'robots' as const, title: 'Robots are seen', action: { text: 'Open the camera', href: cameras[0] ? link('camera', cameras[0].id) : link('camera') }, lasts: false };
  const seen = Math.max(0, ...cameras.map((one) => one.robots));
  if (onlyTried && seen) return { ...base, state: 'todo', text: SIMULATED_ONLY };
  if (!seen) return { ...base, state: 'todo', text: 'Put robots on the field' };
  const check = checks.get('robots');
  return check?.state === 'fail' ? { ...base, state: 'trouble', text: check.text } : { ...base, state: 'done', text: `Up to ${plural(seen, 'robot')} by one camera` };
}

function password(access: Session | null, addresses: string[]): Step {
  const base = { id: 'password' as const, title: 'Password', lasts: true };
  if (!access?.passwords.includes('admin'))
    return { ...base, state: 'todo', text: 'The panel is reachable only from this computer until a password is set', action: { text: 'Set a password', does: 'password' } };
  if (access.may !== 'change')
    return { ...base, state: 'todo', lasts: false, text: 'Sign in to change something', action: { text: 'Sign in', does: 'password' } };
  return { ...base, state: 'done', text: addresses[0] ? `Other computers open ${addresses[0]}` : 'A password is set', action: { text: 'Open on a phone', does: 'address' } };
}

/** The steps to GO, in the recommended order. */
export function firstSteps(status: Status, access: Session | null): Step[] {
  const real = status.cameras.filter(({ origin }) => origin === 'camera');
  // A simulated camera never replaces a real one.
  const cameras = real.length ? real : status.cameras;
  const onlyTried = !real.length && cameras.length > 0;
  const checks = new Map(status.checks.map((check) => [check.id as string, check]));
  const { alerts } = status;
  return [
    camera(real, status.cameras),
    network(status, alerts),
    field(status, checks, alerts, onlyTried || !real.length),
    ofCameras({ id: 'colours', title: 'Colours' }, 'colours', 'Learn the colours', 'Every colour is known', cameras, alerts, onlyTried, ['images_grey', 'colors_missing'], ['colors_swapped', 'margin_thin']),
    ofCameras({ id: 'calibration', title: 'Calibration' }, 'calibration', 'Calibrate', 'Every camera is calibrated', cameras, alerts, onlyTried, ['not_calibrated'], ['calibration_other_size', 'calibration_stale', 'lines_off', 'lines_missing']),
    robots(cameras, checks, onlyTried),
    password(access, status.panel.addresses),
  ];
}

/** The progress stored in this browser. `begun`: it has seen an unfinished lasting step. */
export type Progress = 'unknown' | 'begun' | 'dismissed';

/**
 * Whether to show the steps. A field that was set up does not show them again when its robots are in their boxes or a
 * cable is unplugged: there are alerts for that.
 */
export function showsSteps(steps: Step[], progress: Progress): boolean {
  if (progress === 'dismissed') return false;
  const isOpen = (step: Step) => step.state !== 'done';
  return steps.some((step) => step.lasts && step.state === 'todo') || (progress === 'begun' && steps.some(isOpen));
}
