// A name as the reader may trust it: isolated from the text around, with everything visible that has no shape.
import { visible } from './visible';

export function Name({ text, unknown = 'unknown' }: { text: string; unknown?: string }) {
  if (text === '') return <span class="soft">{unknown}</span>;
  const shown = visible(text);
  return <bdi class="name" title={shown}>{shown}</bdi>;
}
