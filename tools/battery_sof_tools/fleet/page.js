// Shows the recordings whose row holds what is typed.
(function () {
  'use strict';

  const input = document.getElementById('filter'), shown = document.getElementById('shown');
  if (!input) return;
  const rows = Array.from(document.querySelectorAll('#recordings tbody tr'));
  const texts = rows.map((row) => row.textContent.toLowerCase());

  function show() {
    const words = input.value.toLowerCase().split(/\s+/).filter(Boolean);
    let count = 0;
    rows.forEach((row, n) => {
      row.hidden = !words.every((word) => texts[n].includes(word));
      if (!row.hidden) count += 1;
    });
    shown.textContent = count + ' of ' + rows.length;
  }
  input.addEventListener('input', show);
  show();
})();
