// Placeholders of a view without data: loading, empty, or failed.
import type { ComponentChildren } from 'preact';
import type { ApiError } from '../transport/calls';

export const Loading = ({ what }: { what: string }) => <p class="state" role="status">Loading {what} …</p>;

export function Empty({ title, children }: { title: string; children?: ComponentChildren }) {
  return <div class="state empty"><p class="lead">{title}</p>{children}</div>;
}

export function Failure({ what, error, onRetry }: { what: string; error: ApiError; onRetry?: () => void }) {
  return (
    <div class="state failure" role="alert">
      <p class="lead">{what} cannot be shown</p>
      <p>{error.message}{error.reason && <span class="soft"> ({error.reason})</span>}</p>
      {onRetry && <p><button type="button" onClick={onRetry}>Try again</button></p>}
    </div>
  );
}
