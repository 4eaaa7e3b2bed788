// The bounding boxes of a session's objects, drawn for an orbiting camera. The game sends them only while this view is visible, and
// nothing stores them.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { SessionsService } from '../../../gen/sweepstake/v1/sessions_pb';
import { counted, grouped, significant } from '../../../format';
import { type Boxes, boxesOf, type Camera, cellOf, drawBoxes, moved, overlapsOf, START, turned, zoomed } from '../../numbers/boxes';
import { theme } from '../../charts/colours';
import { pausedMs } from '../../charts/view_state';
import { useWidth } from '../../charts/width';
import { Empty, Failure, Loading } from '../../parts/states';
import type { ApiError } from '../../transport/calls';
import { Watch } from '../../transport/events';

const TURN = Math.PI / 24; // radians per key press
const ZOOM = 1.15; // factor per key press
const MOVE = 0.05; // share of the picture per key press
// Errors after which another request would fail too.
const FINAL = new Set(['NOT_FOUND', 'FAILED_PRECONDITION', 'PERMISSION_DENIED']);

function useIsHidden(): boolean {
  const [isHidden, setHidden] = useState(document.hidden);
  useEffect(() => {
    const look = () => setHidden(document.hidden);
    document.addEventListener('visibilitychange', look);
    return () => document.removeEventListener('visibilitychange', look);
  }, []);
  return isHidden;
}

function useBoxes(sessionId: string): { boxes: Boxes | undefined; error: ApiError | undefined; again(): void } {
  const [boxes, setBoxes] = useState<Boxes | undefined>(undefined);
  const [error, setError] = useState<ApiError | undefined>(undefined);
  const [turn, setTurn] = useState(0);
  const isHidden = useIsHidden();
  useEffect(() => {
    if (isHidden) return undefined;
    const watch = new Watch(SessionsService.method.watchBoxes, { sessionId }, {
      messages: ([message]) => { if (message?.view && pausedMs.peek() === undefined) setBoxes(boxesOf(message.view)); },
      status: (status, reason) => {
        setError(status === 'live' ? undefined : reason);
        if (reason && FINAL.has(reason.code)) watch.close();
      },
    });
    return () => watch.close();
  }, [sessionId, turn, isHidden]);
  return { boxes, error, again: () => setTurn(turn + 1) };
}

const KEYS: Readonly<Record<string, (camera: Camera) => Camera>> = {
  ArrowLeft: (camera) => turned(camera, -TURN, 0), ArrowRight: (camera) => turned(camera, TURN, 0),
  ArrowUp: (camera) => turned(camera, 0, TURN), ArrowDown: (camera) => turned(camera, 0, -TURN),
  'Shift ArrowLeft': (camera) => moved(camera, MOVE, 0), 'Shift ArrowRight': (camera) => moved(camera, -MOVE, 0),
  'Shift ArrowUp': (camera) => moved(camera, 0, MOVE), 'Shift ArrowDown': (camera) => moved(camera, 0, -MOVE),
  '+': (camera) => zoomed(camera, ZOOM), '=': (camera) => zoomed(camera, ZOOM), '-': (camera) => zoomed(camera, 1 / ZOOM), '0': () => START,
};

function describe(boxes: Boxes): string {
  const { count, objectCount, stride, pairs, frameIndex } = boxes;
  const shown = stride > 1 ? `${grouped(count)} of ${counted(objectCount, 'object', 'objects')} (one in ${grouped(stride)})` : counted(count, 'object', 'objects');
  return `Frame ${grouped(Number(frameIndex))}: ${shown}, ${grouped(overlapsOf(boxes).size)} of them in ${counted(pairs.length, 'overlapping pair', 'overlapping pairs')}.`;
}

export function Picture({ boxes }: { boxes: Boxes }) {
  const [camera, setCamera] = useState(START);
  const { element, width } = useWidth<HTMLDivElement>();
  const canvas = useRef<HTMLCanvasElement>(null);
  const height = Math.round(Math.min(width * 0.6, 560));
  useLayoutEffect(() => {
    if (!canvas.current || width === 0) return undefined;
    const handle = requestAnimationFrame(() => drawBoxes(canvas.current!, boxes, camera, { width, height }));
    return () => cancelAnimationFrame(handle);
  }, [boxes, camera, width, height, theme.value]);
  const onKeyDown = (event: KeyboardEvent) => {
    const change = KEYS[event.shiftKey && event.key.startsWith('Arrow') ? `Shift ${event.key}` : event.key];
    if (!change || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    setCamera(change);
  };
  const onPointerMove = (event: PointerEvent) => {
    const side = Math.min(width, height);
    const moves = event.buttons === 2 || event.buttons === 4 || (event.buttons === 1 && event.shiftKey);
    if (moves) setCamera((before) => moved(before, event.movementX / side, event.movementY / side));
    else if (event.buttons === 1) setCamera((before) => turned(before, -0.008 * event.movementX, 0.008 * event.movementY));
  };
  return (
    <div class="boxes" ref={element}>
      <canvas ref={canvas} style={{ height }} tabIndex={0} role="img" aria-label={`Boxes of the objects. ${describe(boxes)} Arrow keys turn, with shift they move, plus and minus zoom, 0 shows all.`}
        onKeyDown={onKeyDown} onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)} onPointerMove={onPointerMove} onContextMenu={(event) => event.preventDefault()} />
      <div class="tools">
        <button type="button" class="quiet" onClick={() => setCamera((before) => zoomed(before, ZOOM))}>Nearer</button>
        <button type="button" class="quiet" onClick={() => setCamera((before) => zoomed(before, 1 / ZOOM))}>Farther</button>
        <button type="button" class="quiet" onClick={() => setCamera(START)}>All</button>
        <span class="soft box-count">{describe(boxes)}</span>
        <span class="soft small">Grey: overlaps no other box. Red: overlaps. Blue: pairs. A cell of the ground is {significant(cellOf(boxes), 1)} world units. Drag turns; with shift or the right button it moves.</span>
      </div>
    </div>
  );
}

export function SessionBoxes({ sessionId }: { sessionId: string }) {
  const { boxes, error, again } = useBoxes(sessionId);
  if (error) return <Failure what="The boxes" error={error} onRetry={again} />;
  if (!boxes) return <Loading what="the boxes of the next frame" />;
  return boxes.count === 0 ? <Empty title="The frame had no objects" /> : <Picture boxes={boxes} />;
}
