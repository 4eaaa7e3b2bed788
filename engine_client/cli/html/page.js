'use strict';
// What a page does beyond showing itself: it remembers the theme, shows a point's values at the pointer and with the arrow keys,
// and copies the embedded rows. All is there to read without it.

(function rememberTheme() {
  const choices = document.querySelectorAll('input[name=theme]');
  // A browser may refuse storage to a page from a file.
  try {
    const kept = localStorage.getItem('theme');
    for (const choice of choices) if (choice.value === kept) choice.checked = true;
  } catch (refused) { /* The switch works all the same. */ }
  for (const choice of choices) {
    choice.addEventListener('change', () => {
      try { localStorage.setItem('theme', choice.value); } catch (refused) { /* as above */ }
    });
  }
})();

(function explainPoints() {
  const reach = 36;  // pixels of the picture

  // The point shown with its values; every other line is faint meanwhile.
  function show(svg, tip, point) {
    for (const series of svg.querySelectorAll('.series.on')) series.classList.remove('on');
    svg.classList.toggle('one', point !== null);
    tip.hidden = point === null;
    if (point === null) return;
    const series = point.closest('.series');
    series.classList.add('on');
    const index = series.dataset.series;
    if (index !== undefined) svg.querySelector('.name.k' + index).classList.add('on');
    tip.textContent = point.dataset.text;
    const plot = svg.parentElement;
    const scale = svg.clientWidth / svg.viewBox.baseVal.width;
    const x = point.dataset.x * scale, y = point.dataset.y * scale;
    const left = plot.scrollLeft, right = plot.scrollLeft + plot.clientWidth;
    tip.style.left = Math.max(left, x + 14 + tip.offsetWidth > right ? x - 14 - tip.offsetWidth : x + 14) + 'px';
    tip.style.top = Math.max(0, Math.min(y - tip.offsetHeight / 2, svg.clientHeight - tip.offsetHeight)) + 'px';
  }

  const visible = (svg) => [...svg.querySelectorAll('.point')].filter((point) => point.getClientRects().length > 0);

  function nearest(svg, event) {
    const box = svg.getBoundingClientRect(), scale = box.width / svg.viewBox.baseVal.width;
    const x = (event.clientX - box.left) / scale, y = (event.clientY - box.top) / scale;
    let best = null, least = reach;
    for (const point of visible(svg)) {
      const distance = Math.hypot(point.dataset.x - x, point.dataset.y - y);
      if (distance < least) { least = distance; best = point; }
    }
    return best;
  }

  // Left and right along a line, up and down to the next point at the same place.
  function neighbour(svg, point, key) {
    const points = visible(svg);
    if (point === null) return points[0] ?? null;
    const along = key === 'ArrowLeft' || key === 'ArrowRight';
    const sign = key === 'ArrowRight' || key === 'ArrowDown' ? 1 : -1;
    const lines = svg.querySelector('.line') !== null;
    const same = points.filter((other) => other === point ||
        (along && lines ? other.closest('.series') === point.closest('.series') : !lines || other.dataset.x === point.dataset.x));
    const by = along && lines ? 'x' : 'y';
    same.sort((a, b) => a.dataset[by] - b.dataset[by]);
    return same[same.indexOf(point) + sign] ?? point;
  }

  for (const svg of document.querySelectorAll('.plot svg')) {
    const tip = document.createElement('div');
    tip.className = 'tip';
    tip.hidden = true;
    tip.setAttribute('role', 'status');
    svg.parentElement.append(tip);
    for (const title of svg.querySelectorAll('.point title')) title.remove();
    let focused = null;
    svg.addEventListener('pointermove', (event) => show(svg, tip, nearest(svg, event) ?? focused));
    svg.addEventListener('pointerleave', () => show(svg, tip, focused));
    svg.addEventListener('keydown', (event) => {
      if (event.key === 'Escape') focused = null;
      else if (event.key.startsWith('Arrow')) focused = neighbour(svg, focused, event.key);
      else return;
      event.preventDefault();
      show(svg, tip, focused);
    });
    svg.addEventListener('blur', () => { focused = null; show(svg, tip, null); });
    for (const entry of svg.closest('figure').querySelectorAll('.legend label')) {
      const mark = (on) => {
        svg.classList.toggle('one', on);
        for (const series of svg.querySelectorAll('.series.k' + entry.dataset.series)) series.classList.toggle('on', on);
      };
      entry.addEventListener('pointerenter', () => mark(true));
      entry.addEventListener('pointerleave', () => mark(false));
    }
  }
})();

(function copyRows() {
  function csv(rows) {
    const columns = [...new Set(rows.flatMap(Object.keys))];
    const cell = (value) => {
      const text = value === undefined || value === null ? '' : String(value);
      return /[",\r\n]/.test(text) ? '"' + text.replaceAll('"', '""') + '"' : text;
    };
    return [columns, ...rows.map((row) => columns.map((column) => row[column]))]
        .map((line) => line.map(cell).join(',')).join('\r\n') + '\r\n';
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
      return true;
    } catch (refused) {
      // Pages that the browser does not trust with the clipboard copy what is selected.
      const box = document.createElement('textarea');
      box.value = text;
      document.body.append(box);
      box.select();
      const done = document.execCommand('copy');
      box.remove();
      return done;
    }
  }

  for (const button of document.querySelectorAll('button[data-copy]')) {
    button.parentElement.hidden = false;
    button.addEventListener('click', async () => {
      const json = document.getElementById(button.dataset.source).textContent;
      const text = button.dataset.copy === 'csv' ? csv(JSON.parse(json).rows) : json;
      const said = button.parentElement.querySelector('.copied');
      said.textContent = await copy(text) ? 'Copied.' : 'This browser refuses to copy.';
    });
  }
})();
