// SPDX-License-Identifier: Apache-2.0
// Fits an image into its frame, and computes its scale on the screen.
import { computed, onMounted, onUnmounted, ref, type Ref } from 'vue';
import type { Size } from '../geometry/turn';

export interface View {
  /** 1 shows the whole image. */
  zoom: number;
  /** Offset of the image's centre from the frame's centre, screen pixels. */
  x: number;
  y: number;
}

export const WHOLE: View = { zoom: 1, x: 0, y: 0 };

export interface Box extends Size {
  left: number;
  top: number;
  /** Screen pixels per image pixel. */
  scale: number;
}

export function useFrameSize(frame: Ref<HTMLElement | null>) {
  const size = ref<Size>({ width: 0, height: 0 });
  const observer = new ResizeObserver(([entry]) => {
    if (entry) size.value = { width: entry.contentRect.width, height: entry.contentRect.height };
  });
  onMounted(() => { if (frame.value) observer.observe(frame.value); });
  onUnmounted(() => observer.disconnect());
  return size;
}

export function useBox(frame: Ref<Size>, picture: () => Size, view: () => View) {
  return computed<Box>(() => {
    const { width, height } = picture();
    const { zoom, x, y } = view();
    const scale = Math.min(frame.value.width / width, frame.value.height / height) * zoom;
    return {
      scale, width: width * scale, height: height * scale,
      left: (frame.value.width - width * scale) / 2 + x,
      top: (frame.value.height - height * scale) / 2 + y,
    };
  });
}

/** Whether a JPEG of this width is shown enlarged on a screen with `ratio` device pixels per CSS pixel. */
export function isEnlarged(jpegWidth: number, cameraWidth: number, scale: number, ratio: number): boolean {
  return cameraWidth * scale * ratio > jpegWidth;
}

/** JPEG widths to request: only a few, so that resizing a window does not send a request for each pixel. */
const WIDTHS = [240, 320, 480, 640, 800, 1024, 1280, 1600, 2048];

/** The width to request so that an image shown at this scale is sharp. */
export function sharpWidth(cameraWidth: number, scale: number): number {
  const wanted = cameraWidth * scale * Math.min(devicePixelRatio, 2);
  return Math.min(cameraWidth, WIDTHS.find((width) => width >= wanted) ?? cameraWidth);
}
