// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { parsePreview, parseText } from './messages';

function previewBytes(header: string, jpeg: number[]): ArrayBuffer {
  const json = new TextEncoder().encode(header);
  const bytes = new Uint8Array(4 + json.length + jpeg.length);
  new DataView(bytes.buffer).setUint32(0, json.length, true);
  bytes.set(json, 4);
  bytes.set(jpeg, 4 + json.length);
  return bytes.buffer;
}

describe('text messages', () => {
  it('knows its topics', () => {
    expect(parseText('{"topic":"status","data":{"site":"A"}}')).toMatchObject({ kind: 'status', data: { site: 'A' } });
    expect(parseText('{"topic":"detections","data":{"camera":1}}')).toMatchObject({ kind: 'detections' });
    expect(parseText('{"topic":"field","data":{"number":7}}')).toMatchObject({ kind: 'field', data: { number: 7 } });
    expect(parseText('{"error":"preview: no camera 7"}')).toEqual({ kind: 'error', text: 'preview: no camera 7' });
  });

  it('passes over what it does not know', () => {
    for (const text of ['', '[', '3', 'null', '{"topic":"news","data":{}}', '{"topic":"status"}', '{"topic":"status","data":null}'])
      expect(parseText(text)).toBeNull();
  });
});

describe('preview messages', () => {
  it('splits header and image', () => {
    const message = parsePreview(previewBytes('{"camera":2,"frame":9,"width":780}', [0xff, 0xd8, 0xff]));
    expect(message?.header).toMatchObject({ camera: 2, frame: 9, width: 780 });
    expect([...message!.jpeg]).toEqual([0xff, 0xd8, 0xff]);
  });

  it('counts the header in bytes, not letters', () => {
    const message = parsePreview(previewBytes('{"camera":0,"frame":1,"name":"Süd"}', [1, 2]));
    expect([...message!.jpeg]).toEqual([1, 2]);
  });

  it('refuses what is cut short or garbled', () => {
    expect(parsePreview(new ArrayBuffer(3))).toBeNull();
    expect(parsePreview(previewBytes('{"camera":0,"frame":1}', []))).toBeNull();
    expect(parsePreview(previewBytes('{"camera":0', [1]))).toBeNull();
    expect(parsePreview(previewBytes('{"frame":1}', [1]))).toBeNull();
    const lying = previewBytes('{"camera":0,"frame":1}', [1]);
    new DataView(lying).setUint32(0, 4_000_000_000, true);
    expect(parsePreview(lying)).toBeNull();
  });
});
