// SPDX-License-Identifier: Apache-2.0
import { messageOf } from '../../api/client';
import { saveFile } from '../../api/file';
import type { PictureKind } from '../../api/types';

/** Saves the camera's latest image of that kind in full resolution. Returns an error message, or '' on success. */
export async function saveStill(camera: number, picture: PictureKind): Promise<string> {
  const stamp = new Date().toISOString().slice(0, 19).replace(/[-:]/g, '').replace('T', '-');
  try {
    await saveFile(`cameras/${camera}/snapshot.jpg?quality=95&picture=${picture}`, `camera-${camera}${picture === 'labels' ? '-labels' : ''}-${stamp}.jpg`);
    return '';
  } catch (error) {
    return `The image was not saved: ${messageOf(error)}`;
  }
}
