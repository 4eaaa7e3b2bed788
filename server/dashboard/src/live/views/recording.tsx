// Plays a recording of boxes: a .aabbs file of the user, such as a flight recording. The browser reads the file; nothing is uploaded.
import { useEffect, useState } from 'preact/hooks';
import { grouped } from '../../format';
import type { Boxes } from '../numbers/boxes';
import { openRecording, type Recording } from '../numbers/recording';
import { Select } from '../parts/filter';
import { Name } from '../parts/name';
import { Empty } from '../parts/states';
import { Picture } from './session/boxes';

const RATES = [1, 5, 15, 30, 60, 120]; // frames per second

function Player({ recording, onError }: { recording: Recording; onError(error: Error): void }) {
  const last = recording.frameCount - 1;
  const [frame, setFrame] = useState(0);
  const [boxes, setBoxes] = useState<Boxes | undefined>(undefined);
  const [isPlaying, setPlaying] = useState(false);
  const [rate, setRate] = useState(30);
  useEffect(() => {
    let isLatest = true;
    recording.read(frame).then((read) => { if (isLatest) setBoxes(read); }, (error: Error) => { if (isLatest) onError(error); });
    return () => { isLatest = false; };
  }, [frame]);
  const isShown = boxes?.frameIndex === BigInt(frame);
  useEffect(() => {
    if (!isPlaying || !isShown) return undefined;
    const timer = setTimeout(() => (frame < last ? setFrame(frame + 1) : setPlaying(false)), 1000 / rate);
    return () => clearTimeout(timer);
  }, [isPlaying, isShown, frame, rate]);
  const goTo = (to: number) => {
    setPlaying(false);
    setFrame(Math.min(Math.max(to, 0), last));
  };
  const play = () => {
    if (!isPlaying && frame === last) setFrame(0);
    setPlaying(!isPlaying);
  };
  return (
    <>
      <div class="orders" role="group" aria-label="Player">
        <button type="button" class="primary" onClick={play}>{isPlaying ? 'Stop' : 'Play'}</button>
        <button type="button" disabled={frame === 0} onClick={() => goTo(frame - 1)}>Previous frame</button>
        <button type="button" disabled={frame === last} onClick={() => goTo(frame + 1)}>Next frame</button>
        <Select label="Speed" value={String(rate)} options={RATES.map((each) => [String(each), `${each} frames/s`] as const)} onChange={(value) => setRate(Number(value))} />
        <label class="choice"><span>Frame {grouped(frame)} of {grouped(last)}</span><input type="range" min={0} max={last} value={frame} onInput={(event) => goTo(Number(event.currentTarget.value))} /></label>
      </div>
      {boxes && (boxes.count > 0 ? <Picture boxes={boxes} /> : <Empty title="The frame has no objects" />)}
    </>
  );
}

export function RecordingView() {
  const [opened, setOpened] = useState<{ file: string; recording?: Recording; problem?: string } | undefined>(undefined);
  const open = (file: File | undefined) => {
    if (!file) return;
    openRecording(file).then((recording) => setOpened({ file: file.name, recording }), (error: Error) => setOpened({ file: file.name, problem: error.message }));
  };
  const onDrop = (event: DragEvent) => {
    event.preventDefault();
    open(event.dataTransfer?.files[0]);
  };
  const { file = '', recording, problem } = opened ?? {};
  return (
    <section class="recording" aria-labelledby="recording-heading" onDragOver={(event) => event.preventDefault()} onDrop={onDrop}>
      <h1 id="recording-heading">{recording ? <>Recording of <Name text={recording.name} /></> : 'Recording'}</h1>
      <p class="orders">
        <label class="choice"><span>File</span><input type="file" accept=".aabbs" onChange={(event) => open(event.currentTarget.files?.[0])} /></label>
        <span class="soft">Choose a <code>.aabbs</code> file, or drop it here. The flight recorder writes such files. They stay on this machine.</span>
      </p>
      {problem && <p class="problem" role="alert"><Name text={file} /> cannot be played: {problem}.</p>}
      {recording && <Player key={recording} recording={recording} onError={(error) => setOpened({ file, problem: error.message })} />}
    </section>
  );
}
