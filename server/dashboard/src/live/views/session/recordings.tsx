// The flight recordings of a session's game: which there are is asked for with a click, and so is a file.
import { useEffect, useRef, useState } from 'preact/hooks';
import { SessionsService } from '../../../gen/sweepstake/v1/sessions_pb';
import type { Recording } from '../../../gen/sweepstake/v1/recordings_pb';
import { nsText } from '../../numbers/log_cost';
import { timeText } from '../../parts/clock';
import { save } from '../../parts/download';
import { Failure, Loading } from '../../parts/states';
import { type Column, Table } from '../../parts/table';
import { toast } from '../../parts/toast';
import { fileName } from '../../parts/visible';
import { account, isOperator } from '../../state/account';
import { type ApiError, asApiError, call } from '../../transport/calls';
import { readRecording } from './recording_file';

interface Listed { recording: Recording; writtenMs: number }

const megabytes = (bytes: bigint) => `${(Number(bytes) / 1e6).toFixed(1)} MB`;

// Who leaves the view ends the download.
function Download({ sessionId, listed: { recording, writtenMs } }: { sessionId: string; listed: Listed }) {
  const [ratio, setRatio] = useState<number | undefined>(undefined);
  const stop = useRef<AbortController | undefined>(undefined);
  useEffect(() => () => stop.current?.abort(), []);
  const fetchFile = async () => {
    stop.current = new AbortController();
    const { signal } = stop.current;
    setRatio(0);
    try {
      save(`${fileName('flight', sessionId, String(recording.recordingId))}.aabbs`, await readRecording(sessionId, recording, signal, setRatio));
    } catch (error) {
      if (!signal.aborted) toast(`Not downloaded: ${asApiError(error).message}`, { isBad: true });
    }
    setRatio(undefined);
  };
  const action = ratio === undefined ? 'Download' : `Stop (${Math.floor(100 * ratio)} %)`;
  return (
    <button type="button" class="quiet" aria-label={`${action} the recording of ${timeText(writtenMs)}`}
      onClick={() => { if (ratio === undefined) void fetchFile(); else stop.current?.abort(); }}>{action}</button>
  );
}

const columnsOf = (sessionId: string): readonly Column<Listed>[] => [
  { id: 'time', title: 'Recorded', sort: ({ writtenMs }) => writtenMs, cell: ({ writtenMs }) => timeText(writtenMs) },
  { id: 'worst', title: 'Longest frame', sort: ({ recording }) => Number(recording.worstFrameNs), cell: ({ recording }) => nsText(Number(recording.worstFrameNs)) },
  { id: 'size', title: 'Size', sort: ({ recording }) => Number(recording.sizeBytes), cell: ({ recording }) => megabytes(recording.sizeBytes) },
  { id: 'file', title: 'File', width: '7rem', cell: (listed) => <Download sessionId={sessionId} listed={listed} /> },
];

async function listOf(sessionId: string): Promise<readonly Listed[]> {
  const { recordings } = await call(SessionsService.method.readRecording, { sessionId });
  return recordings.map((recording) => ({ recording, writtenMs: Date.now() - Number(recording.ageMs) }));
}

interface Answer { recordings?: readonly Listed[]; error?: ApiError }

function Answered({ sessionId, answer: { recordings, error }, onRetry }: { sessionId: string; answer: Answer; onRetry(): void }) {
  if (error) return <Failure what="The recordings" error={error} onRetry={onRetry} />;
  if (!recordings?.length) return <p class="soft" role="status">No frame was over the budget yet.</p>;
  return <Table caption="Recordings" columns={columnsOf(sessionId)} rows={recordings} keyOf={({ recording }) => String(recording.recordingId)} sort="time" sortParameter="recordings" />;
}

export function Recordings({ sessionId, isOver }: { sessionId: string; isOver: boolean }) {
  const [answer, setAnswer] = useState<Answer | undefined>(undefined);
  const [isAsking, setAsking] = useState(false);
  const reason = isOver ? 'The session is over.' : isOperator.value ? '' : `To read recordings needs the role operator; yours is ${account.value?.role ?? 'not known'}.`;
  const ask = async () => {
    if (isAsking) return;
    setAsking(true);
    setAnswer(await listOf(sessionId).then((recordings) => ({ recordings }), (error: unknown) => ({ error: asApiError(error) })));
    setAsking(false);
  };
  return (
    <section aria-labelledby="recordings-heading">
      <h2 id="recordings-heading">Flight recordings</h2>
      <p class="orders">
        <button type="button" disabled={reason !== ''} onClick={() => void ask()}>Ask for recordings</button>
        <span class="soft">{reason || <>The boxes and decisions of the five seconds before a frame over the budget. <code>sweepstake-lab replay --recording FILE</code> replays one.</>}</span>
      </p>
      {isAsking && <Loading what="the list from the game" />}
      {!reason && answer && <Answered sessionId={sessionId} answer={answer} onRetry={() => void ask()} />}
    </section>
  );
}
