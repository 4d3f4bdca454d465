// SPDX-License-Identifier: Apache-2.0
import { beforeEach, describe, expect, it } from 'vitest';
import { allHidden, layerList, layers, shownLayers, toggleLayer } from './layers';

beforeEach(() => {
  Object.assign(layers, { detections: true, lines: true, grid: false, labels: false });
  allHidden.value = false;
});

describe('layers', () => {
  it('can all be switched, each with a key of its own', () => {
    expect(layerList.map(({ name }) => name).sort()).toEqual(Object.keys(layers).sort());
    expect(new Set(layerList.map(({ key }) => key)).size).toBe(layerList.length);
  });

  it('are hidden all at once, the labelled picture too, and come back', () => {
    toggleLayer('labels');
    expect(shownLayers.value).toEqual({ detections: true, lines: true, grid: false, labels: true });
    allHidden.value = true;
    expect(Object.values(shownLayers.value)).not.toContain(true);
    allHidden.value = false;
    expect(shownLayers.value.labels).toBe(true);
  });

  it('come back when one of them is asked for', () => {
    toggleLayer('labels');
    allHidden.value = true;
    toggleLayer('labels');
    expect(shownLayers.value).toEqual({ detections: true, lines: true, grid: false, labels: true });
  });
});
