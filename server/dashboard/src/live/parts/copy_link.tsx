// Copies the address of what is shown, filters and all.
import { toast } from './toast';

// The clipboard is there on secure pages only; elsewhere a selection is copied.
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
  toast(wasCopied ? 'Copied' : `This browser does not let the page copy: ${text}`, { isBad: !wasCopied });
}

export const CopyLink = () => <button type="button" class="quiet" onClick={() => void copyText(location.href)}>Copy link</button>;
