// SPDX-License-Identifier: Apache-2.0
// Zooms and pans an image within its frame.
import type { Size } from '../geometry/turn';
import { WHOLE, type View } from './useBox';

export const MAX_ZOOM = 12;

const clamp = (value: number, limit: number) => Math.min(limit, Math.max(-limit, value));

/** Keeps the image over the frame: no panning beyond its edge, and centred if it is smaller. */
function keepInside(view: View, frame: Size, picture: Size): View {
  const scale = Math.min(frame.width / picture.width, frame.height / picture.height) * view.zoom;
  return {
    zoom: view.zoom,
    x: clamp(view.x, Math.max(0, (picture.width * scale - frame.width) / 2)),
    y: clamp(view.y, Math.max(0, (picture.height * scale - frame.height) / 2)),
  };
}

export function panned(view: View, dx: number, dy: number, frame: Size, picture: Size): View {
  return keepInside({ ...view, x: view.x + dx, y: view.y + dy }, frame, picture);
}

/** Zooms around the point (x, y), relative to the frame's centre. */
export function zoomed(view: View, factor: number, x: number, y: number, frame: Size, picture: Size): View {
  const zoom = Math.min(MAX_ZOOM, Math.max(1, view.zoom * factor));
  if (zoom === 1) return WHOLE;
  const by = zoom / view.zoom;
  return keepInside({ zoom, x: x - (x - view.x) * by, y: y - (y - view.y) * by }, frame, picture);
}
