// Colours of a picture on a page.

// Colours [red, green, blue] of an element at points [x, y], in pixels from its left upper corner.
export async function colorsAt(page, element, points) {
  const png = (await element.screenshot()).toString('base64');
  // Decoded on an empty page: the policy of the tested one forbids images of other origins.
  const empty = await page.context().newPage();
  try {
    return await empty.evaluate(
      async ([data, places]) => {
        const picture = new Image();
        picture.src = `data:image/png;base64,${data}`;
        await picture.decode();
        const canvas = document.createElement('canvas');
        canvas.width = picture.width;
        canvas.height = picture.height;
        const context = canvas.getContext('2d');
        context.drawImage(picture, 0, 0);
        return places.map(([x, y]) => [
          ...context.getImageData(Math.round(x), Math.round(y), 1, 1).data.subarray(0, 3),
        ]);
      },
      [png, points],
    );
  } finally {
    await empty.close();
  }
}
