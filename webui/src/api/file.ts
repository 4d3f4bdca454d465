// SPDX-License-Identifier: Apache-2.0
import { ApiError, errorText } from './client';

/** Saves the answer of `api/path` as a file, named by the service or else by `name`. Throws ApiError. */
export async function saveFile(path: string, name: string): Promise<void> {
  const answer = await fetch(`api/${path}`, { cache: 'no-store' }).catch(() => { throw new ApiError(0, 'No answer from the service'); });
  if (!answer.ok) throw new ApiError(answer.status, errorText(await answer.json().catch(() => null), answer.status));
  const address = URL.createObjectURL(await answer.blob());
  const anchor = document.createElement('a');
  anchor.href = address;
  anchor.download = /filename="([^"]+)"/.exec(answer.headers.get('Content-Disposition') ?? '')?.[1] ?? name;
  anchor.click();
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/**
 * The same for a file that is too large for the browser's memory: checks that the service delivers it, then leaves the
 * download and its progress display to the browser. Throws ApiError.
 */
export async function saveLargeFile(path: string): Promise<void> {
  const enough = new AbortController();
  const answer = await fetch(`api/${path}`, { cache: 'no-store', signal: enough.signal }).catch(() => { throw new ApiError(0, 'No answer from the service'); });
  if (!answer.ok) throw new ApiError(answer.status, errorText(await answer.json().catch(() => null), answer.status));
  enough.abort();
  const anchor = document.createElement('a');
  anchor.href = `api/${path}`;
  anchor.download = '';
  anchor.click();
}
