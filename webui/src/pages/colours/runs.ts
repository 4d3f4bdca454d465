// SPDX-License-Identifier: Apache-2.0
// Run-length encoding of labels: a label's value, then the run's length as LEB128 (seven bits per byte, lowest first).
// Used for tables and labelled images.

/** Throws a description of the error unless the runs fill exactly `count` labels. */
export function decodeRuns(bytes: Uint8Array, from: number, count: number): Uint8Array {
  const labels = new Uint8Array(count);
  let at = from;
  let filled = 0;
  while (at < bytes.length) {
    const label = bytes[at++]!;
    let length = 0;
    let shift = 0;
    for (;;) {
      const byte = bytes[at++];
      if (byte === undefined) throw new Error('a run is cut short');
      length += (byte & 0x7f) * 2 ** shift;
      if (byte < 0x80) break;
      shift += 7;
      if (shift > 28) throw new Error('a run is too long');
    }
    if (filled + length > count) throw new Error(`more than ${count} labels`);
    labels.fill(label, filled, filled + length);
    filled += length;
  }
  if (filled !== count) throw new Error(`${filled} labels instead of ${count}`);
  return labels;
}

export interface LabelPicture {
  width: number;
  height: number;
  labels: Uint8Array;
}

/** Width and height, 16 bits each, little-endian, then runs in reading order. */
export function decodeLabelPicture(buffer: ArrayBuffer): LabelPicture {
  const bytes = new Uint8Array(buffer);
  if (bytes.length < 4) throw new Error('a labelled image is cut short');
  const view = new DataView(buffer);
  const [width, height] = [view.getUint16(0, true), view.getUint16(2, true)];
  return { width, height, labels: decodeRuns(bytes, 4, width * height) };
}
