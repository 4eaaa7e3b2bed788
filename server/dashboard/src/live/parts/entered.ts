// A hook that returns whether the pointer or the focus is in an element, whose content must not move then.
import { useState } from 'preact/hooks';

export function useEntered() {
  const [entered, setEntered] = useState({ pointer: false, focus: false });
  const handlers = {
    onPointerEnter: () => setEntered((before) => ({ ...before, pointer: true })),
    onPointerLeave: () => setEntered((before) => ({ ...before, pointer: false })),
    onFocusIn: () => setEntered((before) => ({ ...before, focus: true })),
    onFocusOut: (event: FocusEvent) => {
      const isWithin = (event.currentTarget as Element).contains(event.relatedTarget as Node | null);
      if (!isWithin) setEntered((before) => ({ ...before, focus: false }));
    },
  };
  return { isEntered: entered.pointer || entered.focus, handlers };
}
