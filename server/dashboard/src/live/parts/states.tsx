// Placeholders of a view without data: loading, empty, or failed.
import type { ComponentChildren, ComponentType } from 'preact';
import { type ApiError, send } from '../transport/calls';
import { type Reading, useReading } from '../transport/reading';

export const Loading = ({ what }: { what: string }) => <p class="state" role="status">Loading {what} …</p>;

export const Empty = ({ title, children }: { title: string; children?: ComponentChildren }) =>
  <div class="state empty"><p class="lead">{title}</p>{children}</div>;

export function Failure({ what, error, onRetry }: { what: string; error: ApiError; onRetry?: () => void }) {
  return (
    <div class="state failure" role="alert">
      <p class="lead">{what[0]!.toUpperCase() + what.slice(1)} cannot be shown</p>
      <p>{error.message}{error.reason && <span class="soft"> ({error.reason})</span>}</p>
      {onRetry && <p><button type="button" onClick={onRetry}>Try again</button></p>}
    </div>
  );
}

interface ReadProps<Value> { reading: Reading<Value>; what: string; onRetry?: () => void; children(value: Value): ComponentChildren }

/** Shows the value of a reading, or its error, or a note that the page waits for it. */
export function Read<Value>({ reading: { value, error, again }, what, onRetry = again, children }: ReadProps<Value>) {
  if (error) return <Failure what={what} error={error} onRetry={onRetry} />;
  return value === undefined ? <Loading what={what} /> : <>{children(value)}</>;
}

const loaded = new Map<string, unknown>();

interface LaterProps<Props> { name: string; load: () => Promise<ComponentType<Props>>; props: Props }

/** Loads a view on first use. This fails while the daemon is away, and after its update, because the files of the new version have other
 * names. "Try again" reloads the page, because some browsers do not load a failed file again. It does not while the daemon is away. */
export function Later<Props extends object>({ name, load, props }: LaterProps<Props>) {
  const known = loaded.get(name) as ComponentType<Props> | undefined;
  const reading = useReading(name, async () => known ?? load());
  if (reading.value) loaded.set(name, reading.value);
  const shown = known ? { ...reading, value: known } : reading;
  const retry = () => void send('/livez').then(() => location.reload(), reading.again);
  return <Read reading={shown} what="the view" onRetry={retry}>{(View) => <View {...props} />}</Read>;
}
