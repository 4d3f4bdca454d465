// SPDX-License-Identifier: Apache-2.0

import type { PictureKind } from '../../api/types';

/** Saves the camera's latest picture of that kind in full resolution. Returns what went wrong, or nothing. */
export async function saveStill(camera: number, picture: PictureKind): Promise<string> {
  let response: Response;
  try {
    response = await fetch(`api/cameras/${camera}/snapshot.jpg?quality=95&picture=${picture}`);
  } catch {
    return 'No still: the daemon does not answer';
  }
  if (!response.ok) {
    const body = await response.json().catch(() => null) as { error?: string } | null;
    return `No still: ${body?.error ?? `answer ${response.status}`}`;
  }
  const address = URL.createObjectURL(await response.blob());
  const stamp = new Date().toISOString().slice(0, 19).replace(/[-:]/g, '').replace('T', '-');
  const anchor = document.createElement('a');
  anchor.href = address;
  anchor.download = `camera-${camera}${picture === 'labels' ? '-labels' : ''}-${stamp}.jpg`;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
  return '';
}
