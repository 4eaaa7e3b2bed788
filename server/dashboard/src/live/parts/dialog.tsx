// Confirmation dialogs, one at a time.
import { signal } from '@preact/signals';
import type { ComponentChildren } from 'preact';
import { useEffect, useRef } from 'preact/hooks';

interface Question {
  title: string;
  body: ComponentChildren;  // describes the effect, and whether it can be undone
  action: string;  // the button's label: a verb
  isDangerous?: boolean;
}

const asked = signal<{ question: Question; answer(yes: boolean): void } | undefined>(undefined);

// Opens the dialog. Resolves to true if the user confirms. A question that is still open counts as cancelled.
export function confirmed(question: Question): Promise<boolean> {
  asked.peek()?.answer(false);
  return new Promise((resolve) => {
    asked.value = {
      question,
      answer(yes) {
        asked.value = undefined;
        resolve(yes);
      },
    };
  });
}

// A modal dialog. Escape closes it, and the focus returns to the element that had it before.
export function Modal({ title, onClose, children }: { title: string; onClose(): void; children: ComponentChildren }) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    const before = document.activeElement as HTMLElement | null;
    dialog.current?.showModal();
    return () => before?.focus?.();
  }, []);
  const onCancel = (event: Event) => {
    event.preventDefault();
    onClose();
  };
  return (
    <dialog ref={dialog} aria-labelledby="modal-title" onCancel={onCancel} onClick={(event) => event.target === dialog.current && onClose()}>
      <div class="modal"><h2 id="modal-title">{title}</h2>{children}</div>
    </dialog>
  );
}

export function QuestionHost() {
  if (!asked.value) return null;
  const { question: { title, body, action, isDangerous }, answer } = asked.value;
  return (
    <Modal title={title} onClose={() => answer(false)}>
      <div>{body}</div>
      <p class="buttons">
        <button type="button" autoFocus onClick={() => answer(false)}>Cancel</button>
        <button type="button" class={isDangerous ? 'danger' : 'primary'} onClick={() => answer(true)}>{action}</button>
      </p>
    </Modal>
  );
}
