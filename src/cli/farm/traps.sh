# Both signals end the render and keep its work. USR1: the time is up. TERM: somebody canceled the job, or Slurm takes
# the node away and puts the task back into the queue itself.
canceled=no
trap 'kill -USR1 "$render" 2>/dev/null' USR1
trap 'canceled=yes; kill -TERM "$render" 2>/dev/null' TERM
