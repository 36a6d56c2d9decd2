import type { Api } from '../../api/api';
import type { EstimateResponse, PredictResponse } from '../../api/messages';
import { databaseName } from '../../api/resource_names';
import { floatsOf } from '../../motion/motion';
import {
  meanMarkerError,
  poseAt,
  markersOf,
  observationOf,
  type ObservedMotion,
} from './observed_motion';

// Answers for one moment.
export interface MomentAnswer {
  atSeconds: number;
  estimate: EstimateResponse;
  prediction: PredictResponse;
}

// A predicted pose and, if the observation goes on so long, the pose that then followed.
export interface ComparedPose {
  horizonSeconds: number;
  predicted: Float32Array;
  observed: Float32Array | undefined;
  expectedErrorM: number | undefined;
  // Mean over the markers that both poses have.
  actualErrorM: number | undefined;
  confidence: number | undefined;
  extrapolated: boolean;
}

// Estimates the path of the motion before a moment, and predicts the motion after it.
export async function askMoment(
  api: Api,
  question: { database: string; observed: ObservedMotion; filter: string },
  atSeconds: number,
  historySeconds: number,
  signal: AbortSignal,
): Promise<MomentAnswer> {
  const { observed, filter } = question;
  const database = databaseName(question.database);
  const history = { from: Math.max(0, atSeconds - historySeconds), to: atSeconds };
  const [estimate, prediction] = await Promise.all([
    api.queries.estimate(
      { database, observation: observationOf(observed, history), filter },
      { signal },
    ),
    api.queries.predict(
      { database, observation: observationOf(observed), atSeconds, historySeconds, filter },
      { signal },
    ),
  ]);
  return { atSeconds, estimate, prediction };
}

// The predicted poses beside what then happened.
export function comparePoses(
  observed: ObservedMotion,
  { horizons, atSeconds }: Pick<PredictResponse, 'horizons' | 'atSeconds'>,
): ComparedPose[] {
  const markers = markersOf(observed);
  return horizons.map((frame) => {
    const predicted = floatsOf(frame.markerPositions);
    const then = poseAt(markers, atSeconds + frame.seconds);
    return {
      horizonSeconds: frame.seconds,
      predicted,
      observed: then,
      expectedErrorM: frame.expectedErrorM,
      actualErrorM: then && meanMarkerError(predicted, then),
      confidence: frame.confidence,
      extrapolated: frame.extrapolated,
    };
  });
}

// Moves a pose so that the mean of its markers is above the origin, for a picture of its own.
export function centred(positions: Float32Array, like = positions): Float32Array {
  let x = 0;
  let y = 0;
  let count = 0;
  for (let i = 0; i + 2 < like.length; i += 3) {
    if (Number.isNaN(like[i]!)) continue;
    x += like[i]!;
    y += like[i + 1]!;
    ++count;
  }
  const shift = [x / Math.max(1, count), y / Math.max(1, count), 0];
  return positions.map((value, i) => value - shift[i % 3]!);
}
