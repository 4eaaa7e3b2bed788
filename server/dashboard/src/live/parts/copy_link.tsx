// A button that copies the address of the current view with its filters.
import { toast } from './toast';

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
