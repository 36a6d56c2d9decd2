// Which dropped files belong together: a motion and its skeleton file.

export interface NamedFile {
  readonly name: string;
}

export interface UploadJob<File extends NamedFile> {
  motion: File;
  skeleton: File | undefined;
}

const kSkeleton = /\.(asf|urdf)(\.gz)?$/i;

// Jobs of dropped files. A skeleton file (ASF, URDF) goes with the motions of its kind that begin
// with its name, or with all of its kind if it is the only one.
export function uploadJobs<File extends NamedFile>(files: readonly File[]): UploadJob<File>[] {
  const skeletons = files.filter((file) => kSkeleton.test(file.name));
  const motions = files.filter((file) => !kSkeleton.test(file.name));
  return motions.map((motion) => {
    const wanted = /\.amc(\.gz)?$/i.test(motion.name)
      ? 'asf'
      : /\.csv(\.gz)?$/i.test(motion.name)
        ? 'urdf'
        : '';
    const fitting = skeletons.filter(
      (file) => wanted !== '' && file.name.toLowerCase().includes(`.${wanted}`),
    );
    const named = fitting.filter((file) =>
      motion.name.startsWith(file.name.replace(kSkeleton, '')),
    );
    return { motion, skeleton: named[0] ?? (fitting.length === 1 ? fitting[0] : undefined) };
  });
}
