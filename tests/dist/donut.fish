complete -c donut -f
complete -c donut -l fps -d 'Frames per second; 0 means no limit' -r -f
complete -c donut -l frames -d 'Stop after N frames; the last one stays on the screen' -r -f
complete -c donut -l spin -d 'Speed, in radians per frame [default: 0.04,0.02]' -r -f
complete -c donut -s A -d 'Starting angle A, the tilt, in radians' -r -f
complete -c donut -s B -d 'Starting angle B, clockwise, in radians' -r -f
complete -c donut -l method -d 'classic (grainy, as in 2006) or exact (smooth) [default: classic for donut.c\'s 80x22, else exact]' -r -f -a "classic\t'Plot many points, show the nearest'
exact\t'Follow a ray through the middle of each character'"
complete -c donut -l color -d 'Colour: a name, such as cyan, or 0 to 255' -r -f -a "black\t''
dark_grey\t''
grey\t''
white\t''
red\t''
green\t''
yellow\t''
blue\t''
magenta\t''
cyan\t''
dark_red\t''
dark_green\t''
dark_yellow\t''
dark_blue\t''
dark_magenta\t''
dark_cyan\t''"
complete -c donut -l r2 -d 'Radius of the ring; 8 makes it a thin ring' -r -f
complete -c donut -l k2 -d 'Your distance from it [default: 5, scaled with --r2]' -r -f
complete -c donut -l width -d 'Columns [default: all; in a pipe, 80]' -r -f
complete -c donut -l height -d 'Rows [default: all but 1; at 80x24 or in a pipe, 22]' -r -f
complete -c donut -l aspect -d 'Height of a character divided by its width [default: the terminal\'s, or 2]' -r -f
complete -c donut -s h -l help -d 'Print help (see more with \'--help\')'
complete -c donut -s V -l version -d 'Print version'
