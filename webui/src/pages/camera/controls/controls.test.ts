// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { Control } from '../../../api/types';
import genicam from '../../../testing/genicamControls.json';
import { byCategory, controlTitle, findControls, isSame, isTyped, isWide, sortControls, unitOf } from './controls';

/** The answer of GET /api/cameras/0/controls for Aravis' fake camera. */
const controls = genicam.controls as Control[];
const named = (name: string) => controls.find((control) => control.name === name)!;
const number = (changes: Partial<Control>): Control => ({ ...named('ExposureTimeAbs'), ...changes });
const names = (list: readonly Control[]) => list.map(({ name }) => name);

describe('controls', () => {
  it('begin with what is turned most', () => {
    const { important, others } = sortControls(controls);
    expect(names(important)).toEqual(['ExposureTimeAbs', 'ExposureAuto', 'PixelFormat', 'OffsetX', 'OffsetY', 'Width', 'Height', 'TriggerMode', 'TriggerSoftware', 'TriggerSource']);
    expect(important.length + others.length).toBe(controls.length);
    expect(names(others)).toContain('TestRegister');
  });

  it('are known by the names of V4L2 and IIDC too', () => {
    const other = ['focus_absolute', 'pan_absolute', 'sharpness', 'hue_value', 'temperature_value', 'power_line_frequency', 'zoom_absolute'];
    const known = ['auto_exposure', 'exposure_time_absolute', 'gain', 'white_balance_automatic', 'gamma', 'brightness', 'shutter_absolute', 'gain_mode', 'white_balance_blue_u', 'frame_rate_absolute', 'trigger_on'];
    const { important, others } = sortControls([...other, ...known].map((name) => number({ name })));
    expect(names(important).sort()).toEqual(known.sort());
    expect(names(others)).toEqual(other);
  });

  it('are not hidden where there are few', () => {
    expect(names(sortControls(['paused', 'position'].map((name) => number({ name }))).important)).toEqual(['paused', 'position']);
  });

  it('have titles and units that people read', () => {
    expect(controlTitle(named('ExposureTimeAbs'))).toBe('Exposure time abs');
    expect(controlTitle(named('OffsetX'))).toBe('Offset X');
    expect(controlTitle(number({ name: 'GevSCPSPacketSize' }))).toBe('Gev SCPS packet size');
    expect(controlTitle(named('DeviceModelName'))).toBe('Model Name');
    expect(unitOf(named('ExposureTimeAbs'))).toBe('µs');
    expect(unitOf(named('Width'))).toBe('px');
    expect(unitOf(number({ name: 'shutter_absolute', unit: 's' }))).toBe('s');
  });

  it('know which are dragged by factors and which are typed', () => {
    expect(isWide(named('ExposureTimeAbs'))).toBe(true);
    expect(isWide(number({ min: 0, max: 1e6 }))).toBe(false);
    expect(isWide(number({ min: 1, max: 1000 }))).toBe(false);
    expect(['Width', 'OffsetY', 'PixelFormat', 'BinningVertical'].every((name) => isTyped(named(name)))).toBe(true);
    expect(isTyped(named('ExposureTimeAbs'))).toBe(false);
  });

  it('know what a camera only rounded', () => {
    expect(isSame(number({ step: 0.5 }), 1234.4, 1234)).toBe(true);
    expect(isSame(number({ step: null }), 4999.87, 5000)).toBe(true);
    expect(isSame(number({ step: 1 }), 7, 6)).toBe(false);
    expect(isSame(named('TriggerMode'), 'On', 'Off')).toBe(false);
  });

  it('are found by their words, up to a level', () => {
    expect(names(findControls(controls, 'trigger  activation', 'guru'))).toEqual(['TriggerActivation']);
    expect(names(findControls(controls, 'model', 'beginner'))).toEqual(['DeviceModelName']);
    const expert = number({ name: 'Secret', level: 'expert' });
    expect([findControls([expert], '', 'beginner'), findControls([expert], '', 'expert'), findControls([expert], '', 'guru')].map((list) => list.length)).toEqual([0, 1, 1]);
  });

  it('are grouped as the camera does', () => {
    expect(byCategory(controls).map(({ category }) => category)).toEqual(['Device Control', 'Image Format Control', 'Acquisition Control', 'Transport Layer Control', 'Debug']);
  });
});
