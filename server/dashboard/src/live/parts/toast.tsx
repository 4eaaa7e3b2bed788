// Short messages about the result of an action, with a button to undo it if that is possible.
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

const dismiss = (id: number) => { toasts.value = toasts.peek().filter((each) => each.id !== id); };

// Messages stay while the pointer or the focus is on one of them.
const isReached = () => document.querySelector('.toasts:hover, .toasts:focus-within') !== null;

export function toast(text: string, { undo, isBad = false }: { undo?: () => void; isBad?: boolean } = {}): void {
  const id = nextId++;
  toasts.value = [...toasts.peek().slice(1 - MAX_TOASTS), { id, text, isBad, ...(undo && { undo }) }];
  const later = () => setTimeout(() => (isReached() ? later() : dismiss(id)), isBad ? 2 * SHOWN_MS : SHOWN_MS);
  later();
}

export function ToastHost() {
  return (
    <div class="toasts" role="status" aria-live="polite">
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

// The clipboard API exists on secure pages only; on other pages this copies a selected text.
function copyBySelection(text: string): boolean {
  const area = document.createElement('textarea');
  area.value = text;
  area.className = 'unseen';
  document.body.append(area);
  area.select();
  const wasCopied = document.execCommand('copy');
  area.remove();
  return wasCopied;
}

export async function copyText(text: string): Promise<void> {
  const wasCopied = await (navigator.clipboard?.writeText(text).then(() => true, () => false) ?? false) || copyBySelection(text);
  toast(wasCopied ? 'Copied' : `This browser does not allow copying. Copy the link yourself: ${text}`, { isBad: !wasCopied });
}

export const CopyLink = () => <button type="button" class="quiet" onClick={() => void copyText(location.href)}>Copy link</button>;
