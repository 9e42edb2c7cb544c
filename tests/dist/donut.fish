complete -c donut -f
complete -c donut -l fps -d 'Frames per second; 0 means no limit' -r -f
complete -c donut -l frames -d 'Stop after N frames; the last one stays on the screen' -r -f
complete -c donut -l spin -d 'Rotation from one frame to the next, in radians [default: 0.04,0.02 at 30 frames a second]' -r -f
complete -c donut -s A -d 'Angle A of the first frame, in radians' -r -f
complete -c donut -s B -d 'Angle B of the first frame, in radians' -r -f
complete -c donut -l method -d 'How to draw [default: classic for donut.c\'s picture, exact for others]' -r -f -a "classic\t'As donut.c does: plot many points, and let the nearest win'
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
complete -c donut -l width -d 'Columns [default: all, or 80 in a pipe]' -r -f
complete -c donut -l height -d 'Rows [default: all but 1; 22 in a pipe or in 80x24]' -r -f
complete -c donut -l aspect -d 'Height of a cell divided by its width [default: the terminal\'s, or 2]' -r -f
complete -c donut -l r2 -d 'Radius of the ring, in tube radii' -r -f
complete -c donut -l k2 -d 'Distance to the donut\'s centre, in tube radii [default: 5; with another --r2 R, 5 (1 + R) / 3]' -r -f
complete -c donut -s h -l help -d 'Print help (see more with \'--help\')'
complete -c donut -s V -l version -d 'Print version'
