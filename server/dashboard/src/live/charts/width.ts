// The width that an element has been given.
import { useLayoutEffect, useRef, useState } from 'preact/hooks';

/** Returns a reference to put on the element, and its width in pixels; 0 before it is known. */
export function useWidth<Type extends Element>() {
  const element = useRef<Type>(null);
  const [width, setWidth] = useState(0);
  useLayoutEffect(() => {
    const target = element.current;
    if (!target) return undefined;
    setWidth(Math.floor(target.clientWidth));
    const observer = new ResizeObserver(() => setWidth(Math.floor(target.clientWidth)));
    observer.observe(target);
    return () => observer.disconnect();
  }, []);
  return { element, width };
}
