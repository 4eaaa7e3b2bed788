// Saves a chart as a PNG file: the drawing and the text of its figure, on the card's background.
import { save } from '../parts/download';
import { resolved } from './colours';

const SCALE = 2;
const DRAWN = ['fill', 'fill-opacity', 'stroke', 'stroke-width', 'stroke-opacity', 'stroke-dasharray', 'stroke-linejoin', 'paint-order', 'opacity',
  'font-family', 'font-size', 'font-weight', 'text-anchor', 'display', 'visibility', 'color'];
// Left out of the picture: buttons, text for screen readers, the table.
const LEFT_OUT = '.tools, .unseen, .scroll';

// Returns a copy that looks the same without the page's style sheet.
function standalone(picture: SVGSVGElement): SVGSVGElement {
  const copy = picture.cloneNode(true) as SVGSVGElement;
  const originals = [picture, ...picture.querySelectorAll<SVGElement>('*')];
  [copy, ...copy.querySelectorAll<SVGElement>('*')].forEach((element, i) => {
    const style = getComputedStyle(originals[i]!);
    for (const name of DRAWN) element.setAttribute(name, style.getPropertyValue(name));
    element.removeAttribute('class');
  });
  const { width, height } = picture.getBoundingClientRect();
  copy.setAttribute('width', String(width));
  copy.setAttribute('height', String(height));
  copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
  return copy;
}

async function imageOf(picture: SVGSVGElement): Promise<HTMLImageElement> {
  const url = URL.createObjectURL(new Blob([new XMLSerializer().serializeToString(standalone(picture))], { type: 'image/svg+xml' }));
  try {
    const image = new Image();
    image.src = url;
    await image.decode();
    return image;
  } finally {
    URL.revokeObjectURL(url);
  }
}

// Draws the text word by word at its positions on the page, so that line breaks are the same.
function drawWords(pen: CanvasRenderingContext2D, figure: Element, left: number, top: number): void {
  const walker = document.createTreeWalker(figure, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    const parent = node.parentElement;
    if (!parent || parent.closest(`svg, ${LEFT_OUT}`)) continue;
    const { font, color } = getComputedStyle(parent);
    pen.font = font;
    pen.fillStyle = color;
    for (const { 0: word, index } of (node.textContent ?? '').matchAll(/\S+/g)) {
      const range = document.createRange();
      range.setStart(node, index);
      range.setEnd(node, index + word.length);
      const box = range.getBoundingClientRect();
      if (box.width > 0) pen.fillText(word, box.left - left, box.top - top + box.height * 0.78);
    }
  }
}

export async function savePng(name: string, figure: Element): Promise<void> {
  const { left, top, width, bottom } = figure.getBoundingClientRect();
  const end = figure.querySelector('.scroll')?.getBoundingClientRect().top ?? bottom;
  const canvas = document.createElement('canvas');
  canvas.width = Math.ceil(width * SCALE);
  canvas.height = Math.ceil((end - top) * SCALE);
  const pen = canvas.getContext('2d');
  if (!pen) return;
  pen.scale(SCALE, SCALE);
  pen.fillStyle = resolved('var(--card)');
  pen.fillRect(0, 0, width, end - top);
  for (const part of figure.querySelectorAll<SVGSVGElement | HTMLCanvasElement>('svg, canvas')) {
    const box = part.getBoundingClientRect();
    if (box.width === 0 || box.height === 0 || part.closest(LEFT_OUT)) continue;
    pen.drawImage(part instanceof HTMLCanvasElement ? part : await imageOf(part), box.left - left, box.top - top, box.width, box.height);
  }
  drawWords(pen, figure, left, top);
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, 'image/png'));
  if (blob) save(name, blob);
}
