// The file of a flight recording, read part by part.
import { SessionsService } from '../../../gen/sweepstake/v1/sessions_pb';
import type { Recording } from '../../../gen/sweepstake/v1/recordings_pb';
import { ApiError, call } from '../../transport/calls';

/** Reads the parts of a file until it has all bytes. Throws ApiError, or the signal's reason where it is stopped between two parts. */
export async function readRecording(
  sessionId: string, { recordingId, sizeBytes }: Pick<Recording, 'recordingId' | 'sizeBytes'>, signal: AbortSignal, onProgress: (ratio: number) => void,
): Promise<Blob> {
  const parts: Blob[] = []; // which browsers keep on the disk, where they are many
  for (let offset = 0n; offset < sizeBytes;) {
    signal.throwIfAborted();
    const { data } = await call(SessionsService.method.readRecording, { sessionId, recordingId, offset });
    if (data.length === 0) throw new ApiError('NOT_FOUND', '', 'the game does not have this recording any more; ask again which ones there are');
    parts.push(new Blob([data as BlobPart]));
    offset += BigInt(data.length);
    onProgress(Number(offset) / Number(sizeBytes));
  }
  return new Blob(parts, { type: 'application/octet-stream' });
}
