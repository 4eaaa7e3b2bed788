// Keyboard shortcuts, and the sheet that lists those which work where the reader is.
import { signal } from '@preact/signals';
import { useEffect } from 'preact/hooks';
import { Modal } from './dialog';

export interface Shortcut {
  keys: string;  // one key, or two after one another with a space between: "g o"
  what: string;
  run(): void;
}

const active = signal<readonly Shortcut[]>([]);
const isSheetOpen = signal(false);
const SECOND_KEY_MS = 1500;
let first = { key: '', atMs: 0 };

// Makes the shortcuts work until the returned function is called.
export function addShortcuts(shortcuts: readonly Shortcut[]): () => void {
  active.value = [...active.peek(), ...shortcuts];
  return () => { active.value = active.peek().filter((each) => !shortcuts.includes(each)); };
}

// Makes them work while the component is shown. The list must stay the same one.
export const useShortcuts = (shortcuts: readonly Shortcut[]) => useEffect(() => addShortcuts(shortcuts), [shortcuts]);

const isTyping = (target: EventTarget | null) =>
  target instanceof HTMLElement && (target.isContentEditable || /^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName));

function onKey(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target) || document.querySelector('dialog[open]')) return;
  const both = event.timeStamp - first.atMs < SECOND_KEY_MS ? `${first.key} ${event.key}` : '';
  const found = active.peek().find(({ keys }) => keys === both) ?? active.peek().find(({ keys }) => keys === event.key);
  first = { key: event.key, atMs: event.timeStamp };
  if (!found) return;
  event.preventDefault();
  found.run();
}

export function listenToKeys(): void {
  document.addEventListener('keydown', onKey);
  addShortcuts([{ keys: '?', what: 'Show this list', run: showKeys }]);
}

export function showKeys(): void {
  isSheetOpen.value = true;
}

export function KeySheet() {
  if (!isSheetOpen.value) return null;
  return (
    <Modal title="Keyboard" onClose={() => { isSheetOpen.value = false; }}>
      <dl class="keys">
        {active.value.filter(({ keys }) => keys !== 'Escape').map(({ keys, what }) => (
          <div key={keys}><dt>{keys.split(' ').map((key) => <kbd key={key}>{key}</kbd>)}</dt><dd>{what}</dd></div>
        ))}
        <div><dt><kbd>↑</kbd><kbd>↓</kbd></dt><dd>From row to row in a table</dd></div>
        <div><dt><kbd>←</kbd><kbd>→</kbd></dt><dd>In a chart: move the crosshair, or from decision to decision; <kbd>Home</kbd> and <kbd>End</kbd> to the first and the last</dd></div>
        <div><dt><kbd>+</kbd><kbd>−</kbd><kbd>0</kbd></dt><dd>In a chart: zoom in, zoom out, show all</dd></div>
        <div><dt><kbd>Enter</kbd></dt><dd>Among switches: explain this decision</dd></div>
        <div><dt><kbd>Esc</kbd></dt><dd>Close this list, a question, or an explanation</dd></div>
      </dl>
      <p class="buttons"><button type="button" onClick={() => { isSheetOpen.value = false; }}>Close</button></p>
    </Modal>
  );
}
