// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Alert, Check, Session, Status } from '../api/types';
import { camera, status } from '../testing/samples';
import { firstSteps, showsSteps, type Step } from './firstSteps';

const admin: Session = { may: 'change', signed_in: true, passwords: ['admin'], match_lock: { game_is_running: false, opened: false, locked: false } };
const nobody: Session = { ...admin, signed_in: false, passwords: [] };
const alert = (id: Alert['id'], of: number | null, title = id as string): Alert => ({ id, severity: 'bad', title, fix: '', camera: of, page: null, since: 0 });
const check = (id: Check['id'], value: string, state: Check['state'] = 'pass'): Check => ({ id, title: id, state, value, unit: '', text: '' });
const real = (id: number, changes = {}) => camera({ id, backend: 'aravis', origin: 'camera', ...changes });

const ready = (changes: Partial<Status> = {}): Status => {
  const base = status({
    cameras: [real(0), real(1)], checks: [check('agreement', '4'), check('robots', '6 / 6')],
    panel: { port: 8090, addresses: ['http://192.168.1.10:8090/'] },
  });
  return { ...base, network: { ...base.network, interface: 'enp3s0' }, ...changes };
};
const states = (steps: Step[]) => Object.fromEntries(steps.map(({ id, state }) => [id, state]));
const step = (steps: Step[], id: Step['id']) => steps.find((one) => one.id === id)!;

describe('the way to GO', () => {
  it('begins with everything to do', () => {
    const steps = firstSteps(status({ cameras: [], checks: [] }), nobody);
    expect(new Set(Object.values(states(steps)))).toEqual(new Set(['todo']));
    expect(showsSteps(steps, 'unknown')).toBe(true);
    for (const { action } of steps) expect(action.text).not.toBe('');
  });

  it('ends when all is done', () => {
    const steps = firstSteps(ready(), admin);
    expect(new Set(Object.values(states(steps)))).toEqual(new Set(['done']));
    expect(showsSteps(steps, 'begun')).toBe(false);
    expect(step(steps, 'password').text).toContain('http://192.168.1.10:8090/');
  });

  it('follows the alerts of real cameras', () => {
    const steps = firstSteps(ready({ alerts: [alert('not_calibrated', 1, 'Camera 1 is not calibrated'), alert('colors_missing', 0)] }), admin);
    expect(states(steps)).toMatchObject({ camera: 'done', calibration: 'todo', colours: 'todo' });
    expect(step(steps, 'calibration')).toMatchObject({ text: 'Camera 1 is not calibrated', action: { href: '#/calibration/1' } });
    expect(firstSteps(ready({ alerts: [alert('margin_thin', 0)] }), admin).find(({ id }) => id === 'colours')).toMatchObject({ state: 'trouble' });
  });

  it('does not count a simulated camera as real', () => {
    const simulated = firstSteps(ready({ cameras: [camera()] }), admin);
    expect(states(simulated)).toMatchObject({ camera: 'todo', field: 'todo', colours: 'todo', calibration: 'todo', robots: 'todo', network: 'done', password: 'done' });
    expect(step(simulated, 'camera').text).toContain('A real camera is missing');
    // With a real camera present, the steps ignore it.
    const both = firstSteps(ready({ cameras: [camera({ id: 7 }), real(0, { robots: 0 })], alerts: [alert('not_calibrated', 7)] }), admin);
    expect(states(both)).toMatchObject({ camera: 'done', calibration: 'done', robots: 'todo' });
  });

  it('measures the field by its lines', () => {
    expect(firstSteps(ready({ checks: [check('agreement', '–')] }), admin).find(({ id }) => id === 'field')).toMatchObject({ state: 'todo' });
    expect(firstSteps(ready({ alerts: [alert('field_size', 0)] }), admin).find(({ id }) => id === 'field')).toMatchObject({ state: 'trouble' });
  });

  it('needs packets that leave this computer', () => {
    const of = (card: string, alerts: Alert[] = []) => {
      const now = ready({ alerts });
      return step(firstSteps({ ...now, network: { ...now.network, interface: card } }, admin), 'network').state;
    };
    expect([of('lo'), of('127.0.0.1'), of('enp3s0'), of(''), of('enp3s0', [alert('not_sending', null)])]).toEqual(['todo', 'todo', 'done', 'done', 'trouble']);
  });

  it('is not shown again because robots or cameras are gone for a while', () => {
    const packed = firstSteps(ready({ cameras: [real(0, { robots: 0, state: 'lost', error: 'no answer' })], checks: [] }), admin);
    expect(states(packed)).toMatchObject({ camera: 'trouble', robots: 'todo' });
    expect(showsSteps(packed, 'unknown')).toBe(false);
    expect(showsSteps(packed, 'begun')).toBe(true);
    expect(showsSteps(firstSteps(status({ cameras: [] }), nobody), 'dismissed')).toBe(false);
    expect(showsSteps(firstSteps(ready(), { ...admin, may: 'look', signed_in: false }), 'unknown')).toBe(false);
  });
});
