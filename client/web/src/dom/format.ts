import type { Timestamp } from '@bufbuild/protobuf/wkt';
import { timestampDate } from '@bufbuild/protobuf/wkt';

// Text of numbers, times and sizes.

export function seconds(value: number, digits = 2): string {
  return `${value.toFixed(digits)} s`;
}

// Minutes and seconds of a position in a clip, as in 1:07.25.
export function clock(value: number): string {
  const hundredths = Math.max(0, Math.round(value * 100));
  const minutes = Math.floor(hundredths / 6000);
  const rest = hundredths - minutes * 6000;
  return `${minutes}:${String(Math.floor(rest / 100)).padStart(2, '0')}.${String(rest % 100).padStart(2, '0')}`;
}

export function percent(value: number): string {
  return `${Math.round(value * 100)} %`;
}

export function count(value: number | bigint): string {
  return value.toLocaleString('en-GB');
}

export function bytes(value: number | bigint): string {
  let size = Number(value);
  for (const unit of ['B', 'KiB', 'MiB', 'GiB']) {
    if (size < 1024)
      return `${size >= 100 || unit === 'B' ? Math.round(size) : size.toFixed(1)} ${unit}`;
    size /= 1024;
  }
  return `${size.toFixed(1)} TiB`;
}

// Date and time, as in 2026-05-01 12:00:00Z (UTC); empty without a time.
export function time(value: Timestamp | undefined): string {
  return value ? `${timestampDate(value).toISOString().slice(0, 19).replace('T', ' ')}Z` : '';
}
