// Short messages about what was done, with a way back where there is one.
import { signal } from '@preact/signals';

const SHOWN_MS = 8000;
const MAX_TOASTS = 4;

interface Toast {
  id: number;
  text: string;
  isBad: boolean;
  undo?: () => void;
}

const toasts = signal<readonly Toast[]>([]);
let nextId = 0;
const isReached = signal(false); // the pointer or the focus is there: nothing goes away

function dismiss(id: number): void {
  toasts.value = toasts.peek().filter((each) => each.id !== id);
  if (toasts.peek().length === 0) isReached.value = false;
}

export function toast(text: string, { undo, isBad = false }: { undo?: () => void; isBad?: boolean } = {}): void {
  const id = nextId++;
  toasts.value = [...toasts.peek().slice(1 - MAX_TOASTS), { id, text, isBad, ...(undo && { undo }) }];
  const later = () => setTimeout(() => (isReached.peek() ? later() : dismiss(id)), isBad ? 2 * SHOWN_MS : SHOWN_MS);
  later();
}

export function ToastHost() {
  return (
    <div class="toasts" role="status" aria-live="polite" onPointerEnter={() => { isReached.value = true; }} onPointerLeave={() => { isReached.value = false; }}
      onFocusIn={() => { isReached.value = true; }} onFocusOut={() => { isReached.value = false; }}>
      {toasts.value.map(({ id, text, isBad, undo }) => (
        <div key={id} class={isBad ? 'toast bad' : 'toast'}>
          <span>{text}</span>
          {undo && <button type="button" onClick={() => { dismiss(id); undo(); }}>Undo</button>}
          <button type="button" aria-label="Dismiss" onClick={() => dismiss(id)}>✕</button>
        </div>
      ))}
    </div>
  );
}
