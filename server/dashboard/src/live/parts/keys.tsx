// Keyboard shortcuts, and the dialog that lists the shortcuts of the current view.
import { signal } from '@preact/signals';
import { Modal } from './dialog';

interface Shortcut {
  keys: string;  // one key, or two in sequence separated by a space: "g o"
  what: string;
  run(): void;
}

const active = signal<readonly Shortcut[]>([]);
const isSheetOpen = signal(false);
const SECOND_KEY_MS = 1500;  // maximum time between the two keys of a sequence
let first = { key: '', atMs: 0 };

// Enables the shortcuts until the returned function is called.
export function addShortcuts(shortcuts: readonly Shortcut[]): () => void {
  active.value = [...active.peek(), ...shortcuts];
  return () => { active.value = active.peek().filter((each) => !shortcuts.includes(each)); };
}

const isTyping = (target: EventTarget | null) =>
  target instanceof HTMLElement && (target.isContentEditable || /^(INPUT|TEXTAREA|SELECT)$/.test(target.tagName));

function onKey(event: KeyboardEvent): void {
  if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || isTyping(event.target) || document.querySelector('dialog[open]')) return;
  const both = event.timeStamp - first.atMs < SECOND_KEY_MS ? `${first.key} ${event.key}` : '';
  const found = active.peek().find(({ keys }) => keys === both) ?? active.peek().find(({ keys }) => keys === event.key);
  first = { key: event.key, atMs: event.timeStamp };
  if (!found) {
    if (event.key === 'Escape') document.activeElement?.closest('details[open]')?.removeAttribute('open');
    return;
  }
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
        <div><dt><kbd>↑</kbd><kbd>↓</kbd></dt><dd>In a table: go to the next or previous row</dd></div>
        <div><dt><kbd>←</kbd><kbd>→</kbd></dt><dd>In a chart: move the crosshair, or select the next or previous decision. <kbd>Home</kbd> and <kbd>End</kbd> go to the first and the last.</dd></div>
        <div><dt><kbd>+</kbd><kbd>−</kbd><kbd>0</kbd></dt><dd>In a chart: zoom in, zoom out, show all</dd></div>
        <div><dt><kbd>Enter</kbd></dt><dd>In the chart of switches: explain the selected decision</dd></div>
        <div><dt><kbd>Esc</kbd></dt><dd>Close this list, a dialog, or an explanation</dd></div>
      </dl>
      <p class="buttons"><button type="button" onClick={() => { isSheetOpen.value = false; }}>Close</button></p>
    </Modal>
  );
}
