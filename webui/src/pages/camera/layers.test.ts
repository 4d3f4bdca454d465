// SPDX-License-Identifier: Apache-2.0
import { beforeEach, describe, expect, it } from 'vitest';
import { allHidden, layerList, layers, shownLayers, storedLayers, toggleLayer } from './layers';

const FIRST = { detections: true, lines: true, regions: false, mask: true, over: false, under: false, labels: false, grid: false };

beforeEach(() => {
  Object.assign(layers, FIRST);
  allHidden.value = false;
});

describe('layers', () => {
  it('can all be switched, each with a key of its own', () => {
    expect(layerList.map(({ name }) => name).sort()).toEqual(Object.keys(layers).sort());
    expect(new Set(layerList.map(({ key }) => key)).size).toBe(layerList.length);
  });

  it('are hidden all at once, the labelled image too, and come back', () => {
    toggleLayer('labels');
    expect(shownLayers.value).toEqual({ ...FIRST, labels: true });
    allHidden.value = true;
    expect(Object.values(shownLayers.value)).not.toContain(true);
    allHidden.value = false;
    expect(shownLayers.value.labels).toBe(true);
  });

  it('come back when one of them is asked for', () => {
    toggleLayer('labels');
    allHidden.value = true;
    toggleLayer('labels');
    expect(shownLayers.value).toEqual({ ...FIRST, labels: true });
  });

  it('are as they were left, and as at first where nothing usable was kept', () => {
    expect(storedLayers(null)).toEqual(FIRST);
    expect(storedLayers('{"lines": false, "over": true, "grid": "yes", "trails": true}')).toEqual({ ...FIRST, lines: false, over: true });
    for (const garbled of ['{', '7', 'null', '[]']) expect(storedLayers(garbled)).toEqual(FIRST);
  });
});
