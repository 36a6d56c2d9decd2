// Fingers on a page.

// A function that moves fingers through steps, each a list of places in px of the page, one for each finger.
export async function fingersOf(page) {
  const session = await page.context().newCDPSession(page);
  const touch = (type, places) =>
    session.send('Input.dispatchTouchEvent', {
      type,
      touchPoints: places.map(([x, y], id) => ({ x, y, id })),
    });
  return async ([first, ...others]) => {
    await touch('touchStart', first);
    for (const places of others) await touch('touchMove', places);
    // Fingers rest before they leave. Otherwise the browser goes on with their movement, and the next
    // tap only stops it.
    await new Promise((resolve) => setTimeout(resolve, 100));
    await touch('touchEnd', []);
  };
}

// A function that taps a place in px of the page. Touch and release are sent together: on a busy machine two messages
// that wait for their answers can be so far apart that they are a long press.
export async function tapOf(page) {
  const session = await page.context().newCDPSession(page);
  const send = (type, touchPoints) =>
    session.send('Input.dispatchTouchEvent', { type, touchPoints });
  return (x, y) => Promise.all([send('touchStart', [{ x, y }]), send('touchEnd', [])]);
}
