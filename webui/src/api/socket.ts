// SPDX-License-Identifier: Apache-2.0
// One WebSocket to the daemon that reconnects automatically.
import { backoffMs } from './backoff';
import { parsePreview, parseText, type PreviewMessage, type ServerText } from './messages';
import type { ClientMessage } from './types';

export interface SocketEvents {
  open(): void;
  text(message: ServerText): void;
  preview(message: PreviewMessage): void;
  closed(): void;
}

/** The daemon sends twice a second; a connection this silent is dead, even if TCP has not noticed. */
const SILENCE_MS = 6000;
/** Over a link that is known to be slow, one image may take this long. */
const SLOW_SILENCE_MS = 15_000;

export class PanelSocket {
  private socket: WebSocket | null = null;
  private attempt = 0;
  private lastMessage = 0;
  private readonly watchdog: ReturnType<typeof setInterval>;
  private ended = false;

  constructor(private readonly url: string, private readonly events: SocketEvents, private readonly isSlow: () => boolean = () => false) {
    this.connect();
    this.watchdog = setInterval(() => this.checkSilence(), 1000);
  }

  /** Closes the connection for good. */
  end(): void {
    this.ended = true;
    clearInterval(this.watchdog);
    this.socket?.close();
  }

  get isOpen(): boolean {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** Time of the last message on the browser's monotonic clock, ms; for a new connection, of the connection attempt. */
  get heardAt(): number { return this.lastMessage; }

  send(message: ClientMessage): void {
    if (this.isOpen) this.socket!.send(JSON.stringify(message));
  }

  private connect(): void {
    const socket = new WebSocket(this.url);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    this.lastMessage = performance.now();
    socket.onopen = () => {
      this.attempt = 0;
      this.events.open();
    };
    socket.onmessage = ({ data }) => {
      this.lastMessage = performance.now();
      if (typeof data === 'string') {
        const message = parseText(data);
        if (message) this.events.text(message);
      } else {
        const message = parsePreview(data as ArrayBuffer);
        if (message) this.events.preview(message);
      }
    };
    socket.onclose = () => this.lost(socket);
  }

  private lost(socket: WebSocket): void {
    if (socket !== this.socket) return;
    this.socket = null;
    this.events.closed();
    if (!this.ended) setTimeout(() => { if (!this.ended) this.connect(); }, backoffMs(this.attempt++));
  }

  private checkSilence(): void {
    const socket = this.socket;
    if (!socket || performance.now() - this.lastMessage < (this.isSlow() ? SLOW_SILENCE_MS : SILENCE_MS)) return;
    // On a dead link, close() waits long for its answer, so the loss is reported first.
    this.lost(socket);
    socket.close();
  }
}
