// Comparisons of builds, which the daemon computes (PriorsService.CompareBuilds).
import type { MessageInitShape } from '@bufbuild/protobuf';
import { useEffect, useState } from 'preact/hooks';
import { CompareBuildsRequestSchema, PriorsService, type SceneComparison } from '../../gen/sweepstake/v1/priors_pb';
import { type ApiError, asApiError, jsonOf, stream } from '../transport/calls';

type Request = MessageInitShape<typeof CompareBuildsRequestSchema>;

/** Neither scenes nor an error: the answer has not come yet. */
export interface Answer {
  scenes?: readonly SceneComparison[];
  error?: ApiError;
}

async function read(request: Request, cancel: AbortSignal): Promise<Answer> {
  const scenes: SceneComparison[] = [];
  try {
    for await (const part of stream(PriorsService.method.compareBuilds, request, cancel)) scenes.push(...part.scenes);
    return { scenes };
  } catch (error) {
    return { error: asApiError(error) };
  }
}

/** Reads a comparison, and reads it again if the request changes. */
export function useComparison(request: Request): Answer & { again(): void } {
  const [answer, setAnswer] = useState<Answer>({});
  const [turn, setTurn] = useState(0);
  useEffect(() => {
    const cancel = new AbortController();
    setAnswer({});
    void read(request, cancel.signal).then((read) => cancel.signal.aborted || setAnswer(read));
    return () => cancel.abort();
  }, [jsonOf(CompareBuildsRequestSchema, request), turn]);
  return { ...answer, again: () => setTurn(turn + 1) };
}
