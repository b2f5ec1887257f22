#!/bin/sh
# A film drawn by many machines: an array of jobs, each of which draws every n-th picture, and one more that joins them.
#
#     sh film.sh MACHINES INPUT FILM.mp4 [FLAGS OF meniscus render...]
#     sh film.sh 16 fluid.pvd film.mp4 --size 1920x1080 --interpolate
#
# The pictures are those of a single run, bit for bit, as long as all machines have the same adapter. A job that is put back into
# the queue goes on where it was stopped (--resume). Time, partition and GPU are your site's: set them with SBATCH_TIMELIMIT,
# SBATCH_PARTITION, SBATCH_GPUS.
set -eu

case ${1:-} in
--draw)
    shift
    input=$1 folder=$2
    shift 2
    exec meniscus render "$input" -o "$folder/picture_%06d.png" --resume \
        --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" "$@"
    ;;
--join)
    exec meniscus join "$2/picture_%06d.png" -o "$3" --fps "$4"
    ;;
esac

machines=$1 input=$2 film=$3
shift 3
# The jobs need it too, and have to agree on it.
fps=24
pictures=${film%.*}.pictures
mkdir -p "$pictures"
drawing=$(sbatch --parsable "--array=1-$machines" "$0" --draw "$input" "$pictures" --fps "$fps" "$@")
sbatch --parsable "--dependency=afterok:$drawing" "$0" --join "$pictures" "$film" "$fps"
