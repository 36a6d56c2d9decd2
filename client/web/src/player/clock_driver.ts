import type { Scene } from '../scene/scene';
import type { PlaybackClock } from './playback_clock';

const kLongestStepSeconds = 0.25;

// Moves a clock with the pictures of the screen while it plays: with those of a scene, so that both
// are in the same picture, or without WebGL by itself. Returns the function that ends it.
export function driveClock(clock: PlaybackClock, scene: Scene | undefined): () => void {
  let stop: (() => void) | undefined;
  const advance = (seconds: number) => {
    clock.advance(Math.min(seconds, kLongestStepSeconds));
  };
  const remove = clock.onChange(() => {
    if (clock.playing && !stop) {
      stop = scene ? scene.animate(advance) : animateWithoutScene(advance);
    } else if (!clock.playing && stop) {
      stop();
      stop = undefined;
    }
  });
  return () => {
    remove();
    stop?.();
  };
}

function animateWithoutScene(advance: (seconds: number) => void): () => void {
  let last = 0;
  let request = 0;
  const tick = (time: number) => {
    request = requestAnimationFrame(tick);
    if (last > 0) advance((time - last) / 1000);
    last = time;
  };
  request = requestAnimationFrame(tick);
  return () => {
    cancelAnimationFrame(request);
  };
}
