// SPDX-License-Identifier: Apache-2.0
import type { Detections, FieldTracks, PreviewHeader, Status } from './types';

export type ServerText =
  | { kind: 'status'; data: Status }
  | { kind: 'detections'; data: Detections }
  | { kind: 'field'; data: FieldTracks }
  | { kind: 'error'; text: string };

export interface PreviewMessage {
  header: PreviewHeader;
  jpeg: Uint8Array<ArrayBuffer>;
}

function parseJson(text: string): Record<string, unknown> | null {
  try {
    const value: unknown = JSON.parse(text);
    return value !== null && typeof value === 'object' ? (value as Record<string, unknown>) : null;
  } catch {
    return null;
  }
}

/** Parses a text message; null for one this panel does not know (a newer daemon may send more). */
export function parseText(text: string): ServerText | null {
  const message = parseJson(text);
  if (!message) return null;
  if (typeof message.error === 'string') return { kind: 'error', text: message.error };
  if (message.data === null || typeof message.data !== 'object') return null;
  if (message.topic === 'status') return { kind: 'status', data: message.data as Status };
  if (message.topic === 'detections') return { kind: 'detections', data: message.data as Detections };
  if (message.topic === 'field') return { kind: 'field', data: message.data as FieldTracks };
  return null;
}

const LENGTH_BYTES = 4;
const utf8 = new TextDecoder();

/** Parses a preview: little-endian header length, JSON header, JPEG. Null if truncated or malformed. */
export function parsePreview(buffer: ArrayBuffer): PreviewMessage | null {
  if (buffer.byteLength < LENGTH_BYTES) return null;
  const headerLength = new DataView(buffer).getUint32(0, true);
  const jpegStart = LENGTH_BYTES + headerLength;
  if (jpegStart >= buffer.byteLength) return null;
  const header = parseJson(utf8.decode(new Uint8Array(buffer, LENGTH_BYTES, headerLength)));
  if (!header || typeof header.camera !== 'number' || typeof header.frame !== 'number') return null;
  return { header: header as unknown as PreviewHeader, jpeg: new Uint8Array(buffer, jpegStart) };
}
